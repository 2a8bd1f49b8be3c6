"""The engines that a cell may be simulated in. Only the one that is asked for is imported."""

from kinematics.robot.robot import Robot
from kinematics.simulation.simulated_cell import SimulatedCell

ENGINES = ("bullet", "mujoco")


def cell_in(engine: str, robot: Robot | None = None, gui: bool = False) -> SimulatedCell:
    """Return a cell in one of `ENGINES`, of the Panda by default; a window is Bullet's alone.

    Raises `UnusableRobot`, `NoDisplay`, and `ValueError` for another engine.
    """
    if engine == "mujoco" and not gui:
        from kinematics.simulation.mujoco_cell import MujocoCell

        return MujocoCell(robot)
    if engine == "bullet":
        from kinematics.simulation.bullet_cell import BulletCell

        return BulletCell(robot, gui)
    raise ValueError(f"expected one of {', '.join(ENGINES)}, found {engine}{' with a window' * gui}")
