"""Robot, inverse kinematics, collision, planning, trajectories and the simulated cell. Knows
nothing of tasks.
"""
