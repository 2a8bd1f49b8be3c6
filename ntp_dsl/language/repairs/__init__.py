"""Repairs of arguments, contracts and tasks."""
