"""A wheel carries all that an empty environment needs."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from sources import ROOT

DATA = (
    "ntp_dsl/library/*.ntp",
    "ntp_dsl/templates/*/*",
    "ntp_dsl/traces/page/viewer/*",
    "grammar/*",
    "ntp_dsl/checkpoints/*",
    "*/py.typed",
)


@pytest.fixture(scope="module")
def contents(tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    done = subprocess.run(build, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (wheel,) = folder.glob("*.whl")
    return set(zipfile.ZipFile(wheel).namelist())


@pytest.mark.parametrize("pattern", DATA)
def test_the_wheel_carries_the_data(contents: set[str], pattern: str) -> None:
    wanted = {str(path.relative_to(ROOT)) for path in ROOT.glob(pattern) if path.is_file()}
    assert wanted <= contents
    assert wanted or "checkpoints" in pattern


def test_the_wheel_carries_the_examples_inside_the_package(contents: set[str]) -> None:
    for kind in ("ntp", "py", "urdf"):
        wanted = {f"ntp_dsl/{path.relative_to(ROOT)}" for path in ROOT.glob(f"examples/*/*.{kind}")}
        assert wanted and wanted <= contents


def test_the_wheel_carries_every_module_and_nothing_else(contents: set[str]) -> None:
    packages = [ROOT / name for name in ("ntp_dsl", "kinematics")]
    wanted = {str(path.relative_to(ROOT)) for each in packages for path in each.rglob("*.py")}
    assert wanted <= contents
    tops = {Path(name).parts[0] for name in contents}
    assert {name for name in tops if not name.endswith(".dist-info")} == {
        "ntp_dsl", "kinematics", "grammar",
    }  # fmt: skip
