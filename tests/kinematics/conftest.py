"""One cell for all tests: a reset leaves nothing of an earlier test behind."""

from collections.abc import Iterator

import pytest

from kinematics.simulation import Workcell


@pytest.fixture(scope="session")
def cell() -> Iterator[Workcell]:
    with Workcell() as workcell:
        yield workcell
