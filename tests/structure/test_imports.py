"""Imports run one way, and every heavy library has one home."""

from __future__ import annotations

import subprocess
import sys
from graphlib import CycleError, TopologicalSorter

import pytest
from sources import importers, imports, modules

# From the bottom up; a module may import its own layer and those below. The longest prefix counts.
LAYERS = (
    ("ntp_dsl", "ntp_dsl.files", "ntp_dsl.resources", "ntp_dsl.seeds", "ntp_dsl.workers"),
    ("ntp_dsl.language", "ntp_dsl.registry", "ntp_dsl.graph"),
    ("ntp_dsl.world", "ntp_dsl.predicates", "ntp_dsl.state", "ntp_dsl.task_files"),
    ("ntp_dsl.fitting", "ntp_dsl.skills"),
    ("ntp_dsl.worlds", "ntp_dsl.tasks", "ntp_dsl.goals"),
    ("ntp_dsl.specification", "ntp_dsl.traces", "ntp_dsl.queries", "ntp_dsl.policy"),
    ("ntp_dsl.core",),
    ("ntp_dsl.random_arguments", "ntp_dsl.experts", "ntp_dsl.scripted", "ntp_dsl.interpreter"),
    ("ntp_dsl.labels",),
    ("ntp_dsl.authoring", "ntp_dsl.answers", "ntp_dsl.python_code"),
    ("ntp_dsl.recording", "ntp_dsl.dataset", "ntp_dsl.replay"),
    ("ntp_dsl.dynamic",),
    ("ntp_dsl.evaluation", "ntp_dsl.success", "ntp_dsl.figures", "ntp_dsl.movie"),
    ("ntp_dsl.cli", "ntp_dsl.__main__"),
)
HOMES = {
    "torch": ["ntp_dsl.core"],
    "safetensors": ["ntp_dsl.core"],
    "lark": ["ntp_dsl.language.parser", "ntp_dsl.language.parser_tables"],
    "pygments": ["ntp_dsl.language.highlighting"],
    "rerun": ["ntp_dsl.traces.rerun_file", "kinematics.recording"],
    "typer": ["ntp_dsl.cli"],
    "rich": ["ntp_dsl.cli"],
    "pybullet": ["kinematics"],
    "pybullet_data": ["kinematics"],
    "mujoco": ["kinematics"],
    "mink": ["kinematics"],
    "pinocchio": ["kinematics"],
    "ompl": ["kinematics"],
    "coal": ["kinematics"],
    "kinematics": [
        "kinematics",
        "ntp_dsl.worlds.bullet",
        "ntp_dsl.worlds.bullet_bodies",
        "ntp_dsl.cli.bench",
    ],
    "pink": ["kinematics.bench"],
    "pybullet_planning": ["kinematics.bench"],
}


def within(module: str, home: str) -> bool:
    return module == home or module.startswith(f"{home}.")


def layer(module: str) -> int:
    known = {name: level for level, names in enumerate(LAYERS) for name in names}
    homes = [name for name in known if module == name or name != "ntp_dsl" and within(module, name)]
    assert homes, f"{module} has no layer: say in LAYERS where it belongs"
    return known[max(homes, key=len)]


@pytest.mark.parametrize("module", sorted(name for name in modules() if within(name, "ntp_dsl")))
def test_imports_run_from_the_upper_layers_to_the_lower(module: str) -> None:
    ours = [name for name in imports(module) if within(name, "ntp_dsl")]
    assert [name for name in ours if layer(name) > layer(module)] == []


def test_no_modules_import_one_another_in_a_circle() -> None:
    graph = {module: imports(module) & set(modules()) for module in modules()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"a circle: {' <- '.join(error.args[1])}")


@pytest.mark.parametrize("library", HOMES)
def test_a_heavy_library_is_imported_where_it_belongs(library: str) -> None:
    homes = HOMES[library]
    strangers = [m for m in importers(library) if not any(within(m, home) for home in homes)]
    assert strangers == []


def test_the_arm_knows_nothing_of_tasks() -> None:
    assert not any(within(module, "kinematics") for module in importers("ntp_dsl"))


HEAVY = "torch numpy pyarrow pybullet mujoco pinocchio mink ompl".split()


@pytest.mark.parametrize(
    "statement",
    [
        "import ntp_dsl",
        "import ntp_dsl.cli",
        "from ntp_dsl.cli.app import run; run(['--help'])",
        "from ntp_dsl.cli.app import run; assert run(['check', '--static', 'block_stacking']) == 0",
        "from ntp_dsl.cli.app import run; assert run(['trace', 'show', 'none.jsonl']) == 2",
        "from ntp_dsl.cli.app import run; assert run(['trace', 'diff', 'none.jsonl', 'x']) == 2",
    ],
)
def test_what_is_light_imports_nothing_heavy(statement: str) -> None:
    program = f"import sys; {statement}\nprint('heavy:', *({set(HEAVY)} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "heavy:"
