"""What the base installation can do, and what a command says where its extra is missing."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from collections.abc import Collection
from pathlib import Path

import pytest

from ntp_dsl.cli import extras
from ntp_dsl.cli.app import run
from ntp_dsl.cli.extras import EXTRAS, missing

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
DISTRIBUTIONS = {  # of the modules that are not called as what installs them
    "PIL": "pillow",
    "pinocchio": "pin",
    "pybullet_data": "pybullet",
    "rerun": "rerun-sdk",
    "pink": "pin-pink",
}
RUN_WITHOUT = """
import sys
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {modules!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Missing())
from ntp_dsl.cli.app import run
sys.exit(run({words!r}))
"""


def installed_by(requirements: Collection[str]) -> set[str]:
    return {re.split(r"[^\w-]", requirement)[0] for requirement in requirements}


def run_without(modules: Collection[str], *words: str) -> subprocess.CompletedProcess[str]:
    program = RUN_WITHOUT.format(modules=set(modules), words=list(words))
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("module", EXTRAS)
def test_the_extra_of_a_module_installs_it(module: str) -> None:
    named = PROJECT["optional-dependencies"][EXTRAS[module]]
    assert DISTRIBUTIONS.get(module, module) in installed_by(named)


def test_all_is_every_extra_that_a_command_may_ask_for() -> None:
    (every,) = PROJECT["optional-dependencies"]["all"]
    names = set(every.partition("[")[2].strip("]").split(","))
    assert set(EXTRAS.values()) - {"bench"} <= names <= set(PROJECT["optional-dependencies"])


def test_the_base_installation_has_nothing_heavy() -> None:
    assert installed_by(PROJECT["dependencies"]) == {"jinja2", "lark", "msgspec", "pygments", "rich", "typer"}


@pytest.mark.parametrize(
    "line, lacking, sentence",
    [
        ("run block_stacking block_stacking", EXTRAS, 'ntp run needs {}, which is not installed: pip'),
        ("run block_stacking block_stacking", {"torch"}, 'ntp run needs torch, which is not installed: '
         'pip install "ntp_dsl[learn]"'),
        ("train block_stacking --data x --out y", {"torch"}, 'ntp train needs torch, which is not '
         'installed: pip install "ntp_dsl[learn]"'),
        ("check block_stacking", {"numpy"}, 'ntp check needs numpy, which is not installed: '
         'pip install "ntp_dsl[sim]"; --static needs nothing more'),
        ("trace view x", {"numpy"}, 'ntp trace view needs numpy, which is not installed: '
         'pip install "ntp_dsl[sim]"'),
    ],
)  # fmt: skip
def test_a_missing_extra_is_one_sentence(line: str, lacking: Collection[str], sentence: str) -> None:
    done = run_without(lacking, *line.split())
    assert (done.returncode, done.stdout) == (2, "")
    assert re.match(re.escape(sentence).replace(r"\{\}", r"\w+"), done.stderr)
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    "line",
    [
        "run block_stacking block_stacking --expert --world bullet",
        "eval block_stacking block_stacking --expert --world bullet --episodes 1",
        "bench ik -n 1",
    ],
)
def test_the_bullet_world_says_what_it_lacks(line: str) -> None:
    done = run_without({"pybullet", "pybullet_data"}, *line.split())
    assert done.returncode == 2 and missing(f"ntp {line.split()[0]}", "pybullet") in done.stderr
    assert "Traceback" not in done.stderr


def test_where_pybullet_has_no_wheels_the_sentence_says_what_works(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras.sys, "version_info", (3, 13, 0, "final", 0))
    sentence = missing("ntp run", "pybullet")
    monkeypatch.undo()
    assert sentence == (
        "ntp run needs PyBullet, which has no wheels for Python 3.13: use Python 3.11; "
        "the mujoco world and the kinematic one (--world mujoco, --world kinematic) work here"
    )


def test_a_module_of_no_extra_is_no_sentence() -> None:
    assert missing("ntp run", "email") is None and missing("ntp run", None) is None


@pytest.fixture(scope="module")
def traces(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    files = []
    for slips in ("0", ".5"):
        folder = tmp_path_factory.mktemp("trace")
        words = f"run block_stacking few_placements --world kinematic --expert --seed 3 --slips {slips}"
        assert run([*words.split(), "--out", str(folder)]) == 0
        files.append(str(folder / "episode_00000.trace.jsonl"))
    return files[0], files[1]


@pytest.mark.parametrize(
    "line",
    [
        "check --static block_stacking set_the_table",
        "fmt --check block_stacking set_the_table",
        "graph table_cleanup",
        "trace show A",
        "trace diff A B",
        "trace coverage block_stacking A B",
        "trace export A B --out C",
    ],
)
def test_the_base_installation_has_the_language_and_the_traces(
    line: str, traces: tuple[str, str], tmp_path: Path
) -> None:
    files = {"A": traces[0], "B": traces[1], "C": str(tmp_path / "c.json")}
    done = run_without(EXTRAS, *(files.get(word, word) for word in line.split()))
    assert done.returncode == (1 if "diff" in line else 0), done.stderr


@pytest.mark.parametrize("command", ["run", "eval"])
def test_the_expert_needs_neither_torch_nor_the_arm(command: str) -> None:
    lacking = [module for module, extra in EXTRAS.items() if extra != "sim"]
    line = f"{command} block_stacking few_placements --expert --world kinematic"
    done = run_without(lacking, *line.split())
    assert done.returncode == 0, done.stderr
