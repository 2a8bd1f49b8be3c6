"""Shapes of bodies, and noise on their poses."""
