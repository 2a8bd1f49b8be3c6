"""What all tests share: the libraries that ship, and `--soak` for the large counts."""

from __future__ import annotations

import pytest

from ntp_dsl.language.loader import load
from ntp_dsl.language.registry import Registry


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--soak", action="store_true", help="as many cases as the measured figures were made with"
    )


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "minutes: takes that long, so it is for `--soak` only")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--soak"):
        return
    long = [item for item in items if item.get_closest_marker("minutes")]
    config.hook.pytest_deselected(items=long)
    items[:] = [item for item in items if item not in long]


@pytest.fixture(scope="session")
def soak(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("--soak"))


@pytest.fixture(scope="session")
def stacking() -> Registry:
    return load("block_stacking")
