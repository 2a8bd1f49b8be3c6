"""What the package does in Python without its extras, and what it says where it needs one."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Collection
from pathlib import Path

import pytest

import ntp_dsl
from ntp_dsl.extras import EXTRAS

WITHOUT = """
import sys
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {modules!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Missing())
import ntp_dsl
try:
    {statements}
except ntp_dsl.NtpError as error:
    print(error)
"""
DRAWN = "task = ntp_dsl.draw(ntp_dsl.load('block_stacking'), 'few_placements'); "


def said_without(modules: Collection[str], statements: str) -> str:
    program = WITHOUT.format(modules=set(modules), statements=statements)
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from ntp_dsl.cli.app import run

    folder = tmp_path_factory.mktemp("trace")
    words = "run block_stacking few_placements --world kinematic --expert --seed 3"
    assert run([*words.split(), "--out", str(folder)]) == 0
    return folder / "episode_00000.trace.jsonl"


@pytest.mark.parametrize(
    "statements",
    [
        "ntp_dsl.load('block_stacking')",
        "ntp_dsl.load('table_cleanup')",  # with experts in Python
        "ntp_dsl.load_text('library mine')",
        "assert ntp_dsl.diagnose('block_stacking').is_sound",
        "assert ntp_dsl.diagnose_text('library mine').is_sound",
        "ntp_dsl.call_graph(ntp_dsl.load('block_stacking'))._repr_svg_()",
        "t = ntp_dsl.read_trace({trace!r}); assert ntp_dsl.compare(t, t).first is None",
    ],
)
def test_the_base_installation_has_the_language_and_the_traces(statements: str, trace: Path) -> None:
    assert said_without(EXTRAS, statements.format(trace=str(trace))) == ""


@pytest.mark.parametrize(
    "module, statements, who",
    [
        ("numpy", "ntp_dsl.draw", "draw"),
        ("numpy", "ntp_dsl.run", "run"),
        ("numpy", "ntp_dsl.Policy", "Policy"),
        ("pyarrow", "ntp_dsl.read_demonstration('x.parquet')", "read_demonstration"),
        ("torch", DRAWN + "ntp_dsl.learned_policy(task, ntp_dsl.demonstrate(task))", "learned_policy"),
        ("PIL", "ntp_dsl.picture(None)", "picture"),
    ],
)
def test_what_needs_an_extra_says_which(module: str, statements: str, who: str) -> None:
    install = f'pip install "ntp_dsl[{EXTRAS[module]}]"'
    said = said_without({module}, statements)
    assert said == f"{who} needs {module}, which is not installed: {install}\n"


def test_a_module_of_no_extra_stays_what_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def lacks_another(path: str) -> None:
        raise ModuleNotFoundError("No module named 'juggling'", name="juggling")

    with pytest.raises(ModuleNotFoundError, match="juggling"):
        ntp_dsl._needing("lacks_another", lacks_another)("x")
