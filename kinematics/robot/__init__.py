"""The description of an arm and its gripper, for every solver."""
