"""What all tests share: the libraries that ship, and `--soak` for the large counts."""

from __future__ import annotations

import pytest

from ntp_dsl.language.loader import load
from ntp_dsl.registry import Registry


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--soak", action="store_true", help="as many cases as the measured figures were made with"
    )


@pytest.fixture(scope="session")
def soak(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("--soak"))


@pytest.fixture(scope="session")
def stacking() -> Registry:
    return load("block_stacking")
