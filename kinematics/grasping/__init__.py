"""Grasps and placements."""
