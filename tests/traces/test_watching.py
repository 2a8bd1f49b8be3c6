"""A run is watched in a real browser as it happens, and stepped from there."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from browsing import Page, browser

RUN = "run block_stacking few_placements --world kinematic --seed 3 --watch".split()
SOON = 60  # [s] that a test waits for another process, at most

Started = tuple[subprocess.Popen[str], str]


@contextmanager
def started(folder: Path, *words: str, typed: int = subprocess.DEVNULL) -> Iterator[Started]:
    """Start a run; give the process, and the address of its page, and end it."""
    said = folder / "said.txt"
    with said.open("w", encoding="utf-8") as stream:
        process = subprocess.Popen(
            [sys.executable, "-m", "ntp_dsl", *RUN, *words],
            stdin=typed,
            stdout=subprocess.DEVNULL,
            stderr=stream,
            text=True,
        )
    try:
        yield process, address(said)
    finally:
        process.kill()
        process.communicate(timeout=SOON)


def address(said: Path) -> str:
    """Return the address that a run tells."""
    for _ in range(10 * SOON):
        if found := re.search(r"http://\S+", said.read_text(encoding="utf-8")):
            return found[0]
        time.sleep(0.1)
    raise AssertionError(said.read_text(encoding="utf-8"))


@pytest.fixture
def stepped(tmp_path: Path) -> Iterator[Started]:
    """Run a task that waits at its first decision."""
    with started(tmp_path, "--step") as run:
        yield run


def wait_for(page: Page, text: str, selector: str = "#waiting") -> None:
    page.page.wait_for_selector(f"{selector}:has-text({text!r})")


def post(address: str, command: str) -> int:
    """Return the status of a command to a run."""
    try:
        with urllib.request.urlopen(urllib.request.Request(address + command, b"")) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        return error.code


def waits(address: str) -> None:
    """Return when a run waits."""
    for _ in range(10 * SOON):
        with suppress(urllib.error.HTTPError), urllib.request.urlopen(f"{address}document") as answer:
            if json.load(answer)["waits_for"]:
                return
        time.sleep(0.1)
    raise AssertionError("the run does not wait")


def test_a_run_is_stepped_from_its_page_to_its_end(stepped: Started) -> None:
    process, where = stepped
    with browser() as chromium:
        page = Page(chromium, where)
        wait_for(page, "waits before: stack([]) calls pick_and_place(")
        assert page.text("#summary") == "learned: running" and page.chosen() == "stack([]) … running"
        page.press("s")
        wait_for(page, "waits before: pick_and_place(")
        wait_for(page, "pick_and_place(", ".row.chosen")
        page.page.click("#live button:has-text('over')")
        wait_for(page, "calls place(")
        assert "grasp(" in page.text("#tree")
        page.press("c")
        wait_for(page, "the run is over")
        assert page.text("#summary") == "learned: success" and "running" not in page.text("#tree")
        assert page.page.locator("#live button:visible").count() == 1  # to follow
        assert page.messages == []
        page.close()
    assert process.wait(SOON) == 0


def test_a_run_that_is_only_watched_begins_with_its_first_page(tmp_path: Path) -> None:
    with started(tmp_path, typed=subprocess.PIPE) as (process, where), browser() as chromium:
        assert process.poll() is None
        page = Page(chromium, where)
        wait_for(page, "the run is over")
        assert page.text("#summary") == "learned: success" and page.page.locator(".row").count() > 10
        page.close()
        assert process.wait(SOON) == 0


def test_without_a_page_a_typed_line_begins_it(tmp_path: Path) -> None:
    with started(tmp_path, typed=subprocess.PIPE) as (process, _):
        process.communicate("\n", timeout=SOON)
        assert process.returncode == 0


def test_nobody_without_its_address_sees_or_steps_a_run(stepped: Started) -> None:
    process, where = stepped
    root = where.rsplit("/", 2)[0]
    waits(where)
    elsewhere = urllib.request.Request(f"{where}document", headers={"Host": "example.org"})
    for each in (f"{root}/", f"{root}/document", elsewhere):
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(each)
    assert post(f"{root}/", "step") == 404 and post(where, "quit") == 404
    assert process.poll() is None


def test_a_run_goes_on_as_commands_say_and_they_are_refused_while_nothing_waits(tmp_path: Path) -> None:
    with started(tmp_path, "--break", "release", typed=subprocess.PIPE) as (process, where):
        assert post(where, "step") == 409  # it has not begun
        assert process.stdin is not None
        process.stdin.write("\n")
        process.stdin.flush()
        for _ in range(2):
            waits(where)
            assert post(where, "go") == 200
        process.communicate("c\n" * 9, timeout=SOON)
        assert process.returncode == 0
