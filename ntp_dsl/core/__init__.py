"""The neural core: one for every library, and today's per-library core as a baseline.

Nothing in here knows a program, an api or an object by name.
"""
