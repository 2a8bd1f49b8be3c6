"""The dynamic check: what only a simulation in the kinematic world can tell of a library.

It is `LANGUAGE`'s third kind of check: apis that do not do what they promise, goals that hold before
anything is done or never, experts that go round in circles, functions in Python that are not functions.
"""
