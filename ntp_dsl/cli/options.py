"""Options that several commands share, each described once."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.language.diagnostics.diagnostics import NtpError

Varied = tuple[tuple[str, tuple[int, int]], ...]  # length, topology, semantics -> range

Library = Annotated[
    Path, typer.Argument(help="An .ntp file, a folder that holds one, or the name of an example.")
]
Task = Annotated[str, typer.Argument(help="A task that the library declares.")]
WorldName = Annotated[str, typer.Option("--world", help="kinematic (fast) or bullet (the arm).")]
Seed = Annotated[int, typer.Option(min=0, help="Every random choice hangs on it.")]
Workers = Annotated[int, typer.Option(min=1, help="Processes; the results do not depend on it.")]
Json = Annotated[bool, typer.Option("--json", help="One JSON document on standard output.")]
Model = Annotated[
    Path | None,
    typer.Option(help="A checkpoint of `ntp train`; by default the shipped one that fits."),
]
Scripted = Annotated[bool, typer.Option("--expert", help="The scripted expert decides, not a learned core.")]
Slips = Annotated[float, typer.Option(min=0, max=1, help="How often a transport loses its object.")]
Pushes = Annotated[float, typer.Option(min=0, max=1, help="How often a placement is pushed, and may topple.")]
Gui = Annotated[bool, typer.Option("--gui", help="Watch the bullet world in a window, in real time.")]
Arm = Annotated[
    str | None,
    typer.Option(help="Of the bullet world: panda, xarm6, or a TOML of your own beside its URDF."),
]
Noise = Annotated[float, typer.Option(min=0, max=0.1, help="Of what is observed, standard deviation [m].")]
Length = Annotated[
    str, typer.Option(metavar="N..M", help="How many elements goals have, instead of what the task says.")
]
Topology = Annotated[
    str, typer.Option(metavar="N..M", help="Which arrangements goals may have: 0..9, and 10..19 are others.")
]
Semantics = Annotated[
    str, typer.Option(metavar="N..M", help="Who may take which part: 0..99, and 100..199 are others.")
]


def varied(length: str, topology: str, semantics: str) -> Varied:
    """The ranges that were given for what varies in a task. Raises `NtpError` for what is no range."""
    given = {"length": length, "topology": topology, "semantics": semantics}
    return tuple((name, _range(name, text)) for name, text in given.items() if text)


def _range(name: str, text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,9})(?:\.\.(\d{1,9}))?", text)
    low, high = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
    if low > high:
        raise NtpError(f"--{name}: expected a number or a range such as 4..6, found '{text}'")
    return low, high
