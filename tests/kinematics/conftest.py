"""One cell of each engine for all tests, since a reset leaves nothing of an earlier test; and every arm."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from kinematics_arms import WRITTEN

from kinematics.robot.robot import SHIPPED, Robot, load
from kinematics.simulation.engines import ENGINES, cell_in
from kinematics.simulation.simulated_cell import SimulatedCell


@pytest.fixture(scope="session", params=ENGINES)
def cell(request: pytest.FixtureRequest) -> Iterator[SimulatedCell]:
    """Yield the Panda's, in every engine."""
    with cell_in(request.param) as made:
        yield made


@pytest.fixture(scope="session")
def folder_of_arms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("arms")


@pytest.fixture(params=(*SHIPPED, *WRITTEN))
def robot(request: pytest.FixtureRequest, folder_of_arms: Path) -> Robot:
    """Those that are shipped, and those that are written here."""
    name = request.param
    return load(name if name in SHIPPED else str(WRITTEN[name](folder_of_arms)))
