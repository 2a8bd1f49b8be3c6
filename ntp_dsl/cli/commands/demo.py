"""`ntp demo`: the main job in a minute."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.commands.run import carry_out
from ntp_dsl.cli.display import answers
from ntp_dsl.cli.models import model_for
from ntp_dsl.cli.options import Gui, Json
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.tasks.goal_samplers import Goal

LIBRARY, TASK = examples_folder() / "block_stacking", "block_stacking"


def command(
    seed: Annotated[int, typer.Option(min=0, help="Draws the task and the placements.")] = 4,
    out: Annotated[Path, typer.Option(help="A folder for trace and pictures.")] = Path("runs/demo"),
    gui: Gui = False,
    json: Json = False,
) -> int:
    """Watch the arm build what it was shown once, with the shipped checkpoint.

    A task is drawn from the seed. The expert shows it from one placement of the blocks; then the learned
    program drives the arm from another.

    Example: ntp demo --seed 7
    """
    out.mkdir(parents=True, exist_ok=True)
    plan = Plan(LIBRARY, TASK, model_for(LIBRARY, TASK, None), "bullet", seed, traces=out, gui=gui)
    evaluator = Evaluator(plan)
    instance = evaluator.instance(0)
    if not json:
        answers.print(f"the task: {towers(instance.goal)}")
        answers.print("one demonstration, from another placement of the blocks …")
    shown, _ = evaluator.demonstration(instance, 0)
    if not json:
        answers.print(f"shown in {shown.demonstration.times[-1]:.0f} s; now the learned program:")
    carry_out(evaluator, shown, out, json)
    return 0


def towers(goal: Goal) -> str:
    """The goal in words, tower by tower, from the bottom up."""
    carries = {str(placement["support"]): str(placement["item"]) for placement in goal}
    bases = [support for support in carries if support not in carries.values()]
    lines = []
    for base in bases:
        tower = [base]
        while tower[-1] in carries:
            tower.append(carries[tower[-1]])
        lines.append(" < ".join(tower))
    return "; ".join(lines)
