"""A wheel carries all that an empty environment needs."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterator
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from sources import ROOT

DATA = (
    "ntp_dsl/library/*.ntp",
    "ntp_dsl/templates/*/*",
    "ntp_dsl/traces/page/viewer/*",
    "ntp_dsl/traces/report/report.*",
    "grammar/*",
    "ntp_dsl/checkpoints/*",
    "*/py.typed",
)


MOST_BYTES = 60_000_000  # of the base installation


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    done = subprocess.run(build, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (built,) = folder.glob("*.whl")
    return zipfile.ZipFile(built)


@pytest.fixture(scope="module")
def contents(wheel: zipfile.ZipFile) -> set[str]:
    return set(wheel.namelist())


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


def test_the_wheel_runs_without_the_checkout(wheel: zipfile.ZipFile, tmp_path: Path) -> None:
    wheel.extractall(tmp_path)
    done = subprocess.run(
        [sys.executable, "-m", "ntp_dsl", "check", "--static", "block_stacking"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.startswith("sound: ntp_dsl/examples/block_stacking"), done.stderr


def needed_by(requirements: list[str]) -> Iterator[str]:
    """Return the distributions that requirements install here, and what those need in turn."""
    for requirement in map(Requirement, requirements):
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            yield requirement.name
            yield from needed_by(distribution(requirement.name).requires or [])


def test_the_base_installation_is_small(wheel: zipfile.ZipFile) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    size = sum(entry.file_size for entry in wheel.infolist())
    for name in set(needed_by(project["dependencies"])):
        files = [Path(str(file.locate())) for file in distribution(name).files or []]
        size += sum(file.stat().st_size for file in files if file.is_file())
    assert size <= MOST_BYTES
