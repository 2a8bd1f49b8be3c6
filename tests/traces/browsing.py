"""A real browser for the tests of pages, which are skipped where there is none."""

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
    """Launch headless Chromium, of the machine or of playwright."""
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
    """An open page, with its messages and requests."""

    def __init__(self, browser: Any, file: Path | str, theme: str = "light") -> None:
        self.context = browser.new_context(
            viewport={"width": 1280, "height": 860}, color_scheme=theme, reduced_motion="reduce"
        )
        self.page = self.context.new_page()
        self.messages: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", lambda message: self.messages.append(message.text))
        self.page.on("pageerror", lambda error: self.messages.append(str(error)))
        self.page.on("dialog", lambda dialog: (self.messages.append("a dialog"), dialog.dismiss()))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(file if isinstance(file, str) else file.as_uri())
        self.page.wait_for_selector("body[data-ready=yes]", state="attached", timeout=20_000)

    def press(self, *keys: str) -> Page:
        for key in keys:
            self.page.keyboard.press(key)
        return self

    def text(self, selector: str) -> str:
        return str(self.page.inner_text(selector))

    def chosen(self) -> str:
        """Return the text of the chosen row."""
        return self.text(".row.chosen").replace("\n", " ").strip()

    def run(self, script: str) -> Any:
        return self.page.evaluate(script)

    def close(self) -> None:
        self.context.close()
