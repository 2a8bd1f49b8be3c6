"""`ntp demo`: one-shot imitation in a minute."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.commands.run import run_episode
from ntp_dsl.cli.display import answers
from ntp_dsl.cli.models import model_or_shipped
from ntp_dsl.cli.options import Gui, Json, WorldName
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.tasks.goal_samplers import Goal

LIBRARY, TASK = examples_folder() / "block_stacking", "block_stacking"


def command(
    seed: Annotated[int, typer.Option(min=0, help="Seed of the task and the placements.")] = 4,
    out: Annotated[Path, typer.Option(help="Folder for the trace and pictures.")] = Path("runs/demo"),
    world: WorldName = "bullet",
    gui: Gui = False,
    json: Json = False,
) -> int:
    """Watch the shipped checkpoint build a structure from one demonstration.

    A task is drawn by the seed. The expert demonstrates it from one placement of the blocks; then the
    learned program does it from another.

    Example: ntp demo --seed 7
    """
    out.mkdir(parents=True, exist_ok=True)
    plan = Plan(LIBRARY, TASK, model_or_shipped(None), world, seed, traces=out, gui=gui)
    evaluator = Evaluator(plan)
    instance = evaluator.instance(0)
    if not json:
        answers.print(f"the task: {towers(instance.goal)}")
        answers.print("one demonstration, from another placement of the blocks …")
    recorded, _ = evaluator.demonstration(instance, 0)
    if not json:
        answers.print(f"demonstrated in {recorded.demonstration.times[-1]:.0f} s; now the learned program:")
    run_episode(evaluator, recorded, out, json)
    return 0


def towers(goal: Goal) -> str:
    """Return the goal as text: each tower from the bottom up."""
    carries = {str(placement["support"]): str(placement["item"]) for placement in goal}
    bases = [support for support in carries if support not in carries.values()]
    lines = []
    for base in bases:
        tower = [base]
        while tower[-1] in carries:
            tower.append(carries[tower[-1]])
        lines.append(" < ".join(tower))
    return "; ".join(lines)
