"""The syntax tree, visitors over it, and the formatter."""
