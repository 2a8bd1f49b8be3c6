"""What all tests share: the libraries that ship, and `--soak` for the large counts."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from ntp_dsl.language.loader import load
from ntp_dsl.language.registry import Registry

AUTHORS_FOLDER = os.environ.get("NTP_VAT_DATA")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--soak", action="store_true", help="as many cases as the measured figures were made with"
    )
    parser.addoption(
        "--leave-out-missing",
        action="store_true",
        help="skip, and count, what needs a missing extra",
    )


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "needs(*modules): starts a process that imports them")
    if config.getoption("--leave-out-missing"):
        config.pluginmanager.import_plugin("missing_modules")
    config.addinivalue_line("markers", "minutes: takes that long, so it is for `--soak` only")
    config.addinivalue_line(
        "markers", "authors_data: reads the paper's authors' files; for `--soak` or NTP_VAT_DATA=FOLDER only"
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--soak"):
        return
    markers = {"minutes"} if AUTHORS_FOLDER else {"minutes", "authors_data"}
    left_out = [item for item in items if markers & {marker.name for marker in item.iter_markers()}]
    config.hook.pytest_deselected(items=left_out)
    items[:] = [item for item in items if item not in left_out]


@pytest.fixture(scope="session")
def soak(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("--soak"))


@pytest.fixture(scope="session")
def authors_data() -> Path:
    """Return the folder with the paper's authors' task files; goes with the marker of the same name."""
    folder = Path(AUTHORS_FOLDER or "")
    if not (folder / "stack_unseen_500.json").is_file():
        pytest.skip("the authors' task files are not here: NTP_VAT_DATA=FOLDER says where they are")
    return folder


@pytest.fixture(scope="session")
def stacking() -> Registry:
    return load("block_stacking")
