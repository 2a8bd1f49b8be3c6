"""The simulated cell in PyBullet."""
