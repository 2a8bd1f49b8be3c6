"""The next call of a running program, from its declaration and what is probably the case."""
