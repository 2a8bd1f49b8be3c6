"""How people show a task by hand: each kind has a habit of its own, and anybody some of each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

RATE = 30.0  # frames a second, of a common camera
CHANCE = 0.4  # of a habit to show, wherever it can


class Person(StrEnum):
    """Kinds of people, by what they do."""

    STEADY = "steady"
    TREMOR = "tremor"
    PAUSES = "pauses"
    OVERSHOOTS = "overshoots"
    REGRASPS = "regrasps"
    FALSE_STARTS = "false-starts"
    OFF_CENTRE = "off-centre"
    LOW_LIFTS = "low-lifts"
    GOES_HOME = "goes-home"
    SECOND_THOUGHTS = "second-thoughts"
    NUDGES = "nudges"
    ANYBODY = "anybody"  # some of each


@dataclass(frozen=True)
class Habits:
    """How a person moves. Probabilities are of each motion, grasp or placement."""

    tremor: float = 0.0  # standard deviation of the hand's position [m]
    pauses: float = 0.0
    overshoots: float = 0.0
    regrasps: float = 0.0  # lets go and grasps again
    false_starts: float = 0.0  # reaches for another object first
    off_centre: float = 0.0  # of a grasp, at most along each axis [m]
    clearance: float = 0.1  # of the hand over what it takes, or puts something on [m]
    goes_home: float = 0.0  # between two placements
    second_thoughts: float = 0.0  # puts an object in another place first, and then where it belongs
    nudges: float = 0.0  # pushes an object that it passes


HABITS: Mapping[Person, Habits] = MappingProxyType(
    {
        Person.STEADY: Habits(),
        Person.TREMOR: Habits(tremor=0.002),
        Person.PAUSES: Habits(pauses=CHANCE),
        Person.OVERSHOOTS: Habits(overshoots=CHANCE),
        Person.REGRASPS: Habits(regrasps=CHANCE),
        Person.FALSE_STARTS: Habits(false_starts=CHANCE),
        Person.OFF_CENTRE: Habits(off_centre=0.01),
        Person.LOW_LIFTS: Habits(clearance=0.04),
        Person.GOES_HOME: Habits(goes_home=CHANCE),
        Person.SECOND_THOUGHTS: Habits(second_thoughts=CHANCE),
        Person.NUDGES: Habits(nudges=CHANCE),
        Person.ANYBODY: Habits(
            tremor=0.001,
            pauses=0.15,
            overshoots=0.15,
            regrasps=0.1,
            false_starts=0.1,
            off_centre=0.007,
            clearance=0.05,
            goes_home=0.3,
            second_thoughts=0.1,
            nudges=0.1,
        ),
    }
)
