"""Success rates of the example domains, and the commands of their READMEs: a few here, all with `--soak`."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from evaluation_lines import learnt, ntp

from ntp_dsl.common.resources import examples_folder
from ntp_dsl.evaluation.episodes import Plan, run_all

BY_THE_ARM = [
    pytest.param("object_sorting", "many_objects", 0.97, marks=pytest.mark.minutes),
    ("table_cleanup", "three_and_three", 0.96),
    pytest.param("table_cleanup", "four_and_twelve", 0.90, marks=pytest.mark.minutes),
    ("set_the_table", "set_the_table", 0.97),
]
TRAINED = ["object_sorting", "table_cleanup", "set_the_table"]
EXAMPLES = sorted(path.name for path in examples_folder().iterdir() if path.is_dir())
README_LINE = re.compile(r"^    ntp (.*)$", re.MULTILINE)


@pytest.mark.parametrize("example, task, least", BY_THE_ARM)
def test_an_expert_does_it_with_the_arm(example: str, task: str, least: float, soak: bool) -> None:
    plan = Plan(examples_folder() / example, task, None, "bullet", seed=1)
    count = 100 if soak else 1
    failed = [episode for episode in run_all(plan, count, workers=2 if soak else 1) if not episode.success]
    assert len(failed) <= (1 - least) * count, [
        (each.number, each.attributed_to, each.reason) for each in failed
    ]
    assert all(each.attributed_to for each in failed)


@pytest.mark.needs("torch")
@pytest.mark.parametrize("example", EXAMPLES)
def test_the_lines_of_an_example_work_as_printed(example: str, soak: bool, tmp_path: Path) -> None:
    """Run the commands; without `--soak`, without the arm."""
    lines = README_LINE.findall((examples_folder() / example / "README.md").read_text())
    assert {line.split()[0] for line in lines} >= {"check", "run"}
    for line in lines:
        verb = line.split()[0]
        if not soak:
            line += {"run": " --world kinematic"}.get(verb, "")
        done = ntp(line, tmp_path)
        assert done.returncode == 0, (line, done.stderr)


@pytest.mark.minutes
@pytest.mark.parametrize("example", TRAINED)
def test_the_baseline_learns_a_domain_from_fifty_demonstrations(example: str, tmp_path: Path) -> None:
    model = learnt(examples_folder() / example, tmp_path)
    for world, count in (("kinematic", 200), ("bullet", 50)):
        plan = Plan(examples_folder() / example, example, model, world, seed=7)
        episodes = list(run_all(plan, count, workers=2))
        assert sum(each.success for each in episodes) >= 0.95 * count, world
