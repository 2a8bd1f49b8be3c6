"""A run is watched in a real browser as it happens, and stepped from there."""

from __future__ import annotations

import re
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator

import pytest
from browsing import Page, browser

RUN = "run block_stacking few_placements --world kinematic --seed 3 --watch".split()


@pytest.fixture
def stepped() -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run a task that waits at its first decision; return the process, and the address of its page."""
    process = subprocess.Popen(
        [sys.executable, "-m", "ntp_dsl", *RUN, "--step"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    said = iter(process.stderr.readline, "")
    address = next(found[0] for line in said if (found := re.search(r"http://\S+", line)))
    yield process, address
    process.kill()
    process.communicate()


def wait_for(page: Page, text: str, selector: str = "#waiting") -> None:
    page.page.wait_for_selector(f"{selector}:has-text({text!r})")


def test_a_run_is_stepped_from_its_page_to_its_end(stepped: tuple[subprocess.Popen[str], str]) -> None:
    process, address = stepped
    with browser() as chromium:
        page = Page(chromium, address)
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
    assert process.wait() == 0


def test_nobody_without_its_address_sees_or_steps_a_run(stepped: tuple[subprocess.Popen[str], str]) -> None:
    process, address = stepped
    root = address.rsplit("/", 2)[0]
    elsewhere = urllib.request.Request(f"{address}document", headers={"Host": "example.org"})
    asked = [f"{root}/", f"{root}/document", elsewhere, urllib.request.Request(f"{root}/step", b"")]
    for each in asked:
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(each)
    assert process.poll() is None
    for command in ("step", "go"):
        urllib.request.urlopen(urllib.request.Request(address + command, b"")).close()
    assert process.wait() == 0
