"""One cell for all tests, since a reset leaves nothing of an earlier test; and every arm."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from kinematics_arms import WRITTEN

from kinematics.robot.robot import SHIPPED, Robot, load
from kinematics.simulation.bullet_cell import BulletCell


@pytest.fixture(scope="session")
def cell() -> Iterator[BulletCell]:
    with BulletCell() as workcell:
        yield workcell


@pytest.fixture(scope="session")
def folder_of_arms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("arms")


@pytest.fixture(params=(*SHIPPED, *WRITTEN))
def robot(request: pytest.FixtureRequest, folder_of_arms: Path) -> Robot:
    """Those that are shipped, and those that are written here."""
    name = request.param
    return load(name if name in SHIPPED else str(WRITTEN[name](folder_of_arms)))
