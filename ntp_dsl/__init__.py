"""Declare a library of robot tasks, show a task once, and the arm does it: neural task programming.

    from ntp_dsl.language.loader import load

    registry = load("block_stacking")

Nothing heavy is imported before it is used.
"""

__version__ = "0.1.0"
