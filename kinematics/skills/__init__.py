"""The skills of the arm."""
