"""Options that several commands share."""

from __future__ import annotations

import re
from math import isnan
from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.decision import Dispatch
from ntp_dsl.worlds.habits import RATE, Person
from ntp_dsl.worlds.protocol import LONGEST_LATENCY

Varied = tuple[tuple[str, tuple[int, int]], ...]  # length, topology, semantics -> range


def number(value: float) -> float:
    """Return a number. Raises `BadParameter` for NaN, which no bound excludes."""
    if isnan(value):
        raise typer.BadParameter("expected a number, found nan")
    return value


def optional_number(value: float | None) -> float | None:
    """Return a number, or None. Raises `BadParameter` for NaN."""
    return None if value is None else number(value)


Library = Annotated[Path, typer.Argument(help="An .ntp file, a folder with one, or the name of an example.")]
Task = Annotated[str, typer.Argument(help="A task of the library.")]
WorldName = Annotated[
    str, typer.Option("--world", help="kinematic (fast, no arm), bullet or mujoco (simulated arm).")
]
Seed = Annotated[int, typer.Option(min=0, help="Seed of all random choices.")]
Workers = Annotated[int, typer.Option(min=1, help="Number of processes; does not affect the results.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document to standard output.")]
Model = Annotated[
    Path | None,
    typer.Option(help="A checkpoint of `ntp pretrain` or `ntp train`; by default the core that ships."),
]
Scripted = Annotated[
    bool, typer.Option("--expert", help="Run the scripted expert instead of a learned program.")
]
DispatchBy = Annotated[
    Dispatch | None,
    typer.Option(
        "--dispatch",
        help="How the next call is found: by the language's rule, or by the trained network (the default).",
    ),
]
Slips = Annotated[
    float, typer.Option(min=0, max=1, callback=number, help="Probability that an object slips while carried.")
]
Pushes = Annotated[
    float,
    typer.Option(
        min=0, max=1, callback=number, help="Probability that a placed object is pushed, and may topple."
    ),
]
Latency = Annotated[
    float,
    typer.Option(
        min=0,
        max=LONGEST_LATENCY,
        callback=number,
        help="Delay of every observation in seconds; after each call the robot waits as long.",
    ),
]
CameraOffset = Annotated[
    float,
    typer.Option(
        min=0,
        max=0.2,
        callback=number,
        help="How far a camera is off in metres, in a direction by the seed, perhaps up or down; neither "
        "program nor skills know.",
    ),
]
Spread = Annotated[
    float,
    typer.Option(
        min=0,
        max=0.99,
        callback=number,
        help="Share by which masses and friction are off at most; in a world with an arm.",
    ),
]
WeakGrip = Annotated[
    float,
    typer.Option(
        "--weak-grip",
        min=0,
        max=0.99,
        callback=number,
        help="Share of the hand's force that is missing; in a world with an arm.",
    ),
]
Gui = Annotated[bool, typer.Option("--gui", help="Show the bullet world in a window, in real time.")]
Arm = Annotated[
    str | None,
    typer.Option(help="Arm of the bullet or mujoco world: panda, xarm6, or your own TOML beside its URDF."),
]
Step = Annotated[
    bool, typer.Option("--step", help="Stop before every decision, show it, and wait for a line.")
]
BreakAt = Annotated[
    list[str] | None,
    typer.Option(
        "--break",
        metavar="WHERE",
        help="Stop before a call of a program or api (grasp, or grasp(block_3)), at a line (12), or when a "
        "fact comes about (holding(block_3)); repeat it for several.",
    ),
]
Inject = Annotated[
    list[str] | None,
    typer.Option(
        metavar="CALL=OUTCOME",
        help=(
            "Force what a primitive comes to, once: grasp(block_3)=object_dropped; or what is seen, by all "
            "or by one program: clear(block_2)=false, 'pick(block_1): clear(block_2)=false'. Repeatable."
        ),
    ),
]
Watch = Annotated[
    bool, typer.Option("--watch", help="Show the run on a local page of a browser as it happens.")
]
Viewer = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Show the run in a rerun viewer as it happens: its port on this machine (9876), or its address.",
    ),
]
Noise = Annotated[
    float, typer.Option(min=0, max=0.1, callback=number, help="Standard deviation of observed positions [m].")
]
Say = Annotated[
    list[str] | None,
    typer.Option(
        metavar="TEXT|FILE",
        help="A sentence that says what is to be done, or a file with one a line; repeat it for more.",
    ),
]
DemoNoise = Annotated[
    float,
    typer.Option(
        min=0, max=0.1, callback=number, help="Standard deviation of positions in the demonstration [m]."
    ),
]
WholeScopes = Annotated[
    bool,
    typer.Option(
        "--whole-scopes",
        help="Let every program read its lists from the whole demonstration, not from its own part of it; "
        "the difference shows what scopes contribute.",
    ),
]
DemoBy = Annotated[
    Person | None,
    typer.Option(
        help="Let a simulated person demonstrate, who trembles, pauses, regrasps and so on, or does some of "
        "each (anybody); by default the motion is even."
    ),
]
DemoRate = Annotated[
    float | None,
    typer.Option(
        min=2, max=1000, callback=optional_number, help="Frames a second with --demo-by.  [default: 30]"
    ),
]
Length = Annotated[
    str, typer.Option(metavar="N..M", help="Number of elements of a goal; overrides the task.")
]
Topology = Annotated[
    str,
    typer.Option(
        metavar="N..M",
        help="Range of goal arrangements to draw from; disjoint ranges, as 0..9 and 10..19, share none.",
    ),
]
Semantics = Annotated[
    str,
    typer.Option(
        metavar="N..M",
        help="Range of object assignments to draw from; disjoint ranges, as 0..9 and 10..19, share none.",
    ),
]


def shown_at(by: Person | None, rate: float | None) -> float:
    """Return the rate of a demonstration. Raises `NtpError` where nobody is to show it at that rate."""
    if rate is not None and by is None:
        raise NtpError("--demo-rate goes with --demo-by: say who demonstrates")
    return rate if rate is not None else RATE


def varied(length: str, topology: str, semantics: str) -> Varied:
    """Return the given ranges of what varies in a task. Raises `NtpError` for an invalid range."""
    given = {"length": length, "topology": topology, "semantics": semantics}
    return tuple((name, _range(name, text)) for name, text in given.items() if text)


def _range(name: str, text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,9})(?:\.\.(\d{1,9}))?", text)
    if match is None:
        raise NtpError(f"--{name}: expected a number or a range such as 4..6, found '{text}'")
    low, high = int(match[1]), int(match[2] or match[1])
    if low > high:
        raise NtpError(f"--{name}: the range {text} runs backwards; write {high}..{low}")
    return low, high
