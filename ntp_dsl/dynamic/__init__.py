"""The dynamic check: simulates a library in the kinematic world to find errors that its text does not show.

It finds apis that violate their contract, goals that hold from the start or are never reached, experts that
never end, and nondeterministic functions in Python.
"""
