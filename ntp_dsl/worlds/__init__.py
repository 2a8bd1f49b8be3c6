"""The worlds that ship: a kinematic one, and the planned one with an arm."""
