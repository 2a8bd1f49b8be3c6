"""Imports run one way, and every heavy library has one home."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from graphlib import CycleError, TopologicalSorter

import pytest
from sources import importers, imports, modules

# What each folder may import of the project, besides itself and what those folders may import.
MAY_IMPORT: dict[str, tuple[str, ...]] = {
    "ntp_dsl": ("ntp_dsl.api", "ntp_dsl.libraries", "ntp_dsl.extras"),
    "ntp_dsl.api": ("ntp_dsl.evaluation", "ntp_dsl.libraries"),
    "ntp_dsl.libraries": ("ntp_dsl.graph", "ntp_dsl.user_code"),
    "ntp_dsl.extras": ("ntp_dsl.language",),
    "ntp_dsl.common": (),
    "ntp_dsl.language": ("ntp_dsl.common",),
    "ntp_dsl.graph": ("ntp_dsl.language",),
    "ntp_dsl.soup": ("ntp_dsl.language",),
    "ntp_dsl.semantics": ("ntp_dsl.language",),
    "ntp_dsl.sentences": ("ntp_dsl.semantics",),
    "ntp_dsl.worlds": ("ntp_dsl.semantics", "kinematics.skills"),
    "ntp_dsl.tasks": ("ntp_dsl.worlds",),
    "ntp_dsl.demonstrations": ("ntp_dsl.worlds",),
    "ntp_dsl.traces": ("ntp_dsl.demonstrations", "ntp_dsl.extras"),
    "ntp_dsl.policies": ("ntp_dsl.traces",),
    "ntp_dsl.core": ("ntp_dsl.execution", "ntp_dsl.tasks", "ntp_dsl.soup"),
    "ntp_dsl.authoring": ("ntp_dsl.policies",),
    "ntp_dsl.user_code": ("ntp_dsl.authoring",),
    "ntp_dsl.execution": ("ntp_dsl.policies",),
    "ntp_dsl.datasets": (
        "ntp_dsl.execution",
        "ntp_dsl.tasks",
        "ntp_dsl.user_code",
        "ntp_dsl.sentences",
    ),
    "ntp_dsl.dynamic": ("ntp_dsl.execution", "ntp_dsl.tasks", "ntp_dsl.user_code"),
    "ntp_dsl.evaluation": ("ntp_dsl.datasets", "ntp_dsl.core"),
    "ntp_dsl.cli": (
        "ntp_dsl.evaluation",
        "ntp_dsl.dynamic",
        "ntp_dsl.graph",
        "ntp_dsl.soup",
        "ntp_dsl.extras",
        "kinematics.bench",
    ),
    "ntp_dsl.__main__": ("ntp_dsl.cli",),
    "kinematics": (),
    "kinematics.errors": (),
    "kinematics.geometry": ("kinematics.errors",),
    "kinematics.shapes": ("kinematics.geometry",),
    "kinematics.robot": ("kinematics.shapes",),
    "kinematics.ik": ("kinematics.robot",),
    "kinematics.collision": ("kinematics.robot",),
    "kinematics.planning": ("kinematics.collision",),
    "kinematics.grasping": ("kinematics.collision",),
    "kinematics.simulation": ("kinematics.planning",),
    "kinematics.skills": ("kinematics.simulation", "kinematics.grasping", "kinematics.ik"),
    "kinematics.bench": ("kinematics.skills",),
}
HOMES = {
    "torch": ["ntp_dsl.core"],
    "safetensors": ["ntp_dsl.core"],
    "lark": ["ntp_dsl.language.parsing.parser", "ntp_dsl.language.parsing.parser_tables"],
    "pygments": ["ntp_dsl.language.formatting.pygments_lexer"],
    "rerun": ["ntp_dsl.traces.export.rerun_recording", "kinematics.simulation.rerun_recording"],
    "jinja2": ["ntp_dsl.traces.report.report_page"],
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
        "ntp_dsl.worlds.arm",
        "ntp_dsl.worlds.arm_bodies",
        "ntp_dsl.cli.commands.bench",
    ],
    "pink": ["kinematics.bench"],
    "pybullet_planning": ["kinematics.bench"],
}
MOST_MODULES = 20  # of a folder, so that a reader can survey it


def within(module: str, home: str) -> bool:
    return module == home or module.startswith(f"{home}.")


def home(module: str) -> str:
    """Return the folder of `MAY_IMPORT` that a module is in; the longest name counts."""
    homes = [name for name in MAY_IMPORT if within(module, name)]
    found = max(homes, key=len)
    tops = {"ntp_dsl", "kinematics"}
    assert found not in tops or module in tops, f"{module}: say in MAY_IMPORT what it may import"
    return found


def allowed(folder: str) -> set[str]:
    """Return the folder itself and everything that it may import, directly or indirectly."""
    found, waiting = set(), [folder]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += MAY_IMPORT[name]
    return found


@pytest.mark.parametrize("module", sorted(modules()))
def test_a_module_imports_what_its_folder_may(module: str) -> None:
    ours = [name for name in imports(module) if name.split(".")[0] in ("ntp_dsl", "kinematics")]
    may = allowed(home(module))
    assert [name for name in ours if home(name) not in may and name in modules()] == []


def test_no_folder_holds_more_modules_than_a_reader_takes_in() -> None:
    folders = Counter(file.parent for file in modules().values() if file.name != "__init__.py")
    assert {str(folder): count for folder, count in folders.items() if count > MOST_MODULES} == {}


def test_no_modules_import_one_another_in_a_circle() -> None:
    graph = {module: imports(module) & set(modules()) for module in modules()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"a circle: {' <- '.join(error.args[1])}")


@pytest.mark.parametrize("library", HOMES)
def test_a_heavy_library_is_imported_where_it_belongs(library: str) -> None:
    homes = HOMES[library]
    others = [m for m in importers(library) if not any(within(m, home) for home in homes)]
    assert others == []


def test_the_arm_knows_nothing_of_tasks() -> None:
    assert not any(within(module, "kinematics") for module in importers("ntp_dsl"))


HEAVY = "torch numpy pyarrow pybullet mujoco pinocchio mink ompl".split()


@pytest.mark.parametrize(
    "statement",
    [
        "import ntp_dsl",
        "import ntp_dsl.cli.app",
        "from ntp_dsl.cli.app import run; run(['--help'])",
        "from ntp_dsl.cli.app import run; assert run(['check', '--static', 'block_stacking']) == 0",
        "from ntp_dsl.cli.app import run; assert run(['trace', 'show', 'none.jsonl']) == 2",
        "from ntp_dsl.cli.app import run; assert run(['trace', 'diff', 'none.jsonl', 'x']) == 2",
    ],
)
def test_what_is_light_imports_nothing_heavy(statement: str) -> None:
    program = f"import sys; {statement}\nprint('heavy:', *({set(HEAVY)} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "heavy:"
