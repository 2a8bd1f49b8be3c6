"""The neural core: Algorithm 1 of Neural Task Programming (Xu et al., ICRA 2018) over a registry.

Nothing in here knows a program, an api or an object by name.
"""
