"""`ntp bench`: speed and success rate of the kinematics, against other libraries."""

from __future__ import annotations

from importlib import import_module
from typing import Annotated, Any

import typer

from ntp_dsl.cli.display import answers, messages, print_json
from ntp_dsl.cli.options import Json, Seed
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest

COUNTS = {"ik": 1000, "plan": 1000, "sim": 50}


def command(
    what: Annotated[str, typer.Argument(help="ik (inverse kinematics), plan (planning) or sim (execution).")],
    count: Annotated[
        int | None,
        typer.Option(
            "-n", "--count", min=1, help="Number of queries of each kind, or of pick-and-place cycles."
        ),
    ] = None,
    arm: Annotated[str, typer.Option(help="A shipped arm, or your own TOML beside its URDF.")] = "panda",
    seed: Seed = 0,
    json: Json = False,
) -> int:
    """Benchmark inverse kinematics, planning or execution against other libraries on the same queries.

    Compared are mink and PyBullet, and with the extra `bench` also pink and pybullet_planning.
    `overhead` is the time of the skills divided by that of replaying their motor commands, minus one.

    Example: ntp bench ik -n 200 --json
    """
    if what not in COUNTS:
        raise NtpError(f"there is no benchmark '{what}'; did you mean '{nearest(what, COUNTS) or 'ik'}'?")
    figures = _measure(what, count or COUNTS[what], seed, arm)
    if json:
        print_json(figures)
        return 0
    _show("ours", figures["ours"])
    for name, peer in figures["peers"].items():
        _show(name, peer)
    _show("times faster than", figures.get("times_faster", {}))
    return 0


def _measure(what: str, count: int, seed: int, arm: str) -> dict[str, Any]:
    from kinematics.errors import UnusableRobot
    from kinematics.robot.robot import load
    from kinematics.simulation import pybullet_loading

    if what != "sim":  # whose peers need PyBullet: said before anything else is done
        pybullet_loading.load()
    try:
        robot = load(arm)
        messages.print(f"{count} of each kind, on one processor core; this takes a while")
        with pybullet_loading.output_silenced():
            figures: dict[str, Any] = import_module(f"kinematics.bench.{what}").bench(count, seed, robot)
    except UnusableRobot as unusable:
        raise NtpError(str(unusable)) from unusable
    return figures


def _show(name: str, figures: dict[str, Any]) -> None:
    for key, value in figures.items():
        if isinstance(value, dict):
            _show(f"{name}, {key}", value)
    plain = {key: value for key, value in figures.items() if not isinstance(value, dict)}
    if plain:
        answers.print(f"{name:<32}" + "  ".join(f"{key} {value}" for key, value in plain.items()))
