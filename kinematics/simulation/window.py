"""A window that shows the simulation as it runs, if there is a display."""

import ctypes
import ctypes.util
import os
import sys
import time
from typing import Any

from kinematics.errors import NoDisplay
from kinematics.shapes.bodies import Body
from kinematics.simulation import pybullet_loading

_VIEW = {  # from the front and above, as the camera's
    "cameraDistance": 1.4,
    "cameraYaw": 55.0,
    "cameraPitch": -30.0,
    "cameraTargetPosition": (0.4, 0.0, 0.15),
}
_OPENING = 0.5  # during which the window's thread prints about its graphics [s]


def connect(world: Any) -> int:
    """Return a PyBullet client with a window; raise `NoDisplay` if there is no display."""
    _check_display()
    with pybullet_loading.output_silenced():
        client: int = world.connect(world.GUI)
        if client < 0:
            raise NoDisplay("no window could be opened; leave the window out")
        world.configureDebugVisualizer(world.COV_ENABLE_GUI, 0, physicsClientId=client)
        world.resetDebugVisualizerCamera(**_VIEW, physicsClientId=client)
        time.sleep(_OPENING)
    return client


def paint(world: Any, client: int, identity: int, body: Body) -> None:
    """Give a body its own colour."""
    world.changeVisualShape(identity, -1, rgbaColor=body.colour, physicsClientId=client)


def _check_display() -> None:
    """Raise `NoDisplay` without an X server, for which PyBullet would end the whole process."""
    if not sys.platform.startswith("linux"):
        return
    named = os.environ.get("DISPLAY")
    if not named:
        raise NoDisplay("there is no display for a window: set DISPLAY, or leave the window out")
    library = ctypes.util.find_library("X11")
    if library is None:
        raise NoDisplay("there is no X11 library for a window: install libX11, or leave the window out")
    x11 = ctypes.CDLL(library)
    x11.XOpenDisplay.restype = ctypes.c_void_p
    display = x11.XOpenDisplay(named.encode())
    if display is None:
        raise NoDisplay(f"the display {named} does not answer: start it, or leave the window out")
    x11.XCloseDisplay(ctypes.c_void_p(display))
