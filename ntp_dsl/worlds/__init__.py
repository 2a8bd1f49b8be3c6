"""Worlds in which primitives are carried out: the protocol, a kinematic world, and the arm in Bullet."""
