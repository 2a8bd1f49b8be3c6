"""For `--leave-out-missing`: tests that come upon a module of an extra that is not installed are skipped.

`make test-pythons` runs so, where no wheels of PyBullet are. The summary counts what was left out.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Generator
from importlib.util import find_spec
from typing import Any

import pytest

from ntp_dsl.cli.extras import EXTRAS

REASON = " is not installed"


class Finder:
    """The last of the finders: whoever asks it for a module of an extra did not find it elsewhere."""

    @staticmethod
    def find_spec(name: str, path: object = None, target: object = None) -> None:
        leave_out(name)


def leave_out(module: str | None) -> None:
    """Skip, if it is one of ours: a part that an installed module lacks is nobody's extra."""
    if module in EXTRAS:
        pytest.skip(f"{module}{REASON}", allow_module_level=True)


def pytest_runtest_setup(item: pytest.Item) -> None:
    for marker in item.iter_markers("needs"):
        for module in marker.args:
            find_spec(module)  # which asks the finder above, if nobody else has it


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None, Any, Any]:
    """Skip where a worker process, which has no such finder, lacked a module."""
    try:
        return (yield)
    except ModuleNotFoundError as error:
        leave_out(error.name)
        raise


def pytest_configure() -> None:
    sys.meta_path.append(Finder)


def pytest_unconfigure() -> None:
    sys.meta_path.remove(Finder)


def pytest_terminal_summary(terminalreporter: Any) -> None:
    reasons = (report.longrepr[2] for report in terminalreporter.stats.get("skipped", ()))
    counts = Counter(reason.removeprefix("Skipped: ") for reason in reasons)
    for reason, count in counts.most_common():
        if reason.endswith(REASON):
            terminalreporter.write_line(f"left out, since {reason}: {count} tests or files of tests")
