"""Inverse kinematics: global, and along straight lines."""
