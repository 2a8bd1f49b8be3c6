"""Instances of tasks: scenes and goals, drawn or read from a file."""
