"""Robots, inverse kinematics, collision checks, planning and a simulated cell; independent of tasks."""
