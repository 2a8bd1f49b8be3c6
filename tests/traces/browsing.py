"""A real browser for the tests of pages; where a machine has none they are skipped, and say so."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
MISSING = "no browser here: install Chromium (apt install chromium, or playwright install chromium)"


@contextmanager
def browser() -> Iterator[Any]:
    """Headless Chromium, of the machine or of playwright."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with api.sync_playwright() as playwright:
        found = next((path for name in NAMES if (path := shutil.which(name))), None)
        if found is None and not Path(playwright.chromium.executable_path).is_file():
            pytest.skip(MISSING)
        launched = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        try:
            yield launched
        finally:
            launched.close()


class Page:
    """A page that is open, with all that it said and asked for."""

    def __init__(self, browser: Any, file: Path, theme: str = "light") -> None:
        self.context = browser.new_context(
            viewport={"width": 1280, "height": 860}, color_scheme=theme, reduced_motion="reduce"
        )
        self.page = self.context.new_page()
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("dialog", lambda dialog: (self.said.append("a dialog"), dialog.dismiss()))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(file.as_uri())
        self.page.wait_for_selector("body[data-ready=yes]", state="attached", timeout=20_000)

    def press(self, *keys: str) -> Page:
        for key in keys:
            self.page.keyboard.press(key)
        return self

    def text(self, selector: str) -> str:
        return str(self.page.inner_text(selector))

    def chosen(self) -> str:
        """The call that is chosen, as the first trace has it, else the second."""
        return self.text(".row.chosen").replace("\n", " ").strip()

    def run(self, script: str) -> Any:
        return self.page.evaluate(script)

    def close(self) -> None:
        self.context.close()
