"""Options that several commands share, each described once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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
Scripted = Annotated[
    bool, typer.Option("--expert", help="The scripted expert decides, not a learned core.")
]
Slips = Annotated[
    float, typer.Option(min=0, max=1, help="How often a transport loses its object.")
]
Pushes = Annotated[
    float, typer.Option(min=0, max=1, help="How often a placement is pushed, and may topple.")
]
Noise = Annotated[float, typer.Option(min=0, max=0.1, help="Of what is observed, standard deviation [m].")]
