"""A page on this machine that shows a run as it happens, and from which it can be stepped."""

from __future__ import annotations

import json
import secrets
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from queue import Queue
from threading import Condition, Thread
from typing import Any

from ntp_dsl.cli.display import messages
from ntp_dsl.cli.trace_folders import demonstration_file
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.page.page import encoded, live_page, page_document
from ntp_dsl.traces.reader import Unstarted, read_trace
from ntp_dsl.traces.trace import Trace

HERE = "127.0.0.1"
LOOKS = 0.3  # [s] between two looks at the trace
FAREWELL = 5.0  # [s] that a page has for fetching the end
LINES = {"step": "\n", "over": "o\n", "go": "c\n"}  # of the page's buttons, as if typed at the terminal
NOT_YET = """<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="1">
<title>ntp run</title><p>The run has not begun; this page looks again every second."""


class Watched:
    """A run that pages show: its trace, what it waits for, and the lines that say how to go on."""

    def __init__(self, trace: Path) -> None:
        self._path = trace
        self._lines: Queue[str] = Queue()
        self._waits_for = ""
        self._is_over = False
        self._changes = 0
        self._changed = Condition()
        self._pages = 0  # that follow it
        self._farewells = 0  # pages that have fetched the end

    # The run's side ---------------------------------------------------------------------------

    def wait_for(self, text: str) -> None:
        """Show what the run waits for; nothing, where the text is empty."""
        with self._changed:
            self._waits_for = text
            self._changes += 1
            self._changed.notify_all()

    def read_line(self) -> str:
        """Return the next line that was typed at the terminal, or chosen on a page."""
        return self._lines.get()

    def listen(self) -> None:
        """Pass on what is typed, to the end of the input."""
        while line := sys.stdin.readline():
            self._lines.put(line)
        if sys.stdin.isatty():
            self._lines.put("")  # else a page may still say how to go on

    def end(self) -> None:
        """Let the pages fetch the end."""
        with self._changed:
            self._is_over = True
            self._changed.notify_all()
            pages = self._pages
            self._changed.wait_for(lambda: self._farewells >= pages, FAREWELL)

    # The pages' side --------------------------------------------------------------------------

    def put(self, line: str) -> None:
        """Go on as a page says."""
        self._lines.put(line)

    def versions(self) -> Iterator[int]:
        """Yield a number whenever there is something new, the last one at the run's end."""
        with self._changed:
            self._pages += 1
        try:
            told = None
            while True:
                over = self._is_over
                now = self._changes, over, self._path.stat().st_size if self._path.is_file() else 0
                if now != told:
                    told = now
                    yield self._changes
                if over:
                    return
                with self._changed:
                    self._changed.wait(LOOKS)
        finally:
            with self._changed:
                self._pages -= 1

    def fetched(self) -> None:
        """Note that a page has what was new."""
        with self._changed:
            self._farewells += self._is_over
            self._changed.notify_all()

    def page(self) -> str:
        """Return the page of what there is so far. Raises `Unstarted` where that is nothing."""
        trace, shown = self._read()
        return live_page(trace, self._path.parent, shown)

    def document(self) -> str:
        """Return what the page is to show now, as JSON. Raises `Unstarted` as `page` does."""
        trace, shown = self._read()
        goes_on = not self._is_over
        whole = encoded(page_document(compare(trace, trace), (self._path.parent,), shown, goes_on))
        told = {"waits_for": self._waits_for, "is_over": self._is_over}
        return f'{{"document":{whole},{json.dumps(told)[1:]}'

    def _read(self) -> tuple[Trace, Demonstration | None]:
        trace = read_trace(self._path)
        file = demonstration_file(trace, self._path)
        return trace, read_demonstration(file) if file else None


@contextmanager
def watched(trace: Path) -> Iterator[Watched]:
    """Serve pages of a run while it goes on, at an address that nobody can guess."""
    run = Watched(trace)
    server = ThreadingHTTPServer((HERE, 0), _handler(run, token := secrets.token_urlsafe(12)))
    server.daemon_threads = True
    Thread(target=server.serve_forever, daemon=True).start()
    messages.print(f"watch it at http://{HERE}:{server.server_port}/{token}/")
    try:
        yield run
    finally:
        run.end()
        server.shutdown()
        server.server_close()


def _handler(run: Watched, token: str) -> type[BaseHTTPRequestHandler]:
    """Return what answers requests; without the token, nothing is found."""

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self) -> None:
            try:
                match self._asked():
                    case "":
                        self._send(run.page(), "text/html")
                    case "document":
                        self._send(run.document(), "application/json")
                        run.fetched()
                    case "events":
                        self._stream()
                    case _:
                        self._refuse()
            except Unstarted:
                if self._asked():
                    self._refuse()
                else:
                    self._send(NOT_YET, "text/html")

        def do_POST(self) -> None:
            line = LINES.get(self._asked() or "")
            if line is None:
                self._refuse()
                return
            run.put(line)
            self._send("", "text/plain")

        def log_message(self, format: str, *args: Any) -> None:
            """Leave the terminal to the run."""

        def _asked(self) -> str | None:
            """Return what is asked for; None of another host's page, or without the token."""
            host = self.headers.get("Host", "").rpartition(":")[0]
            begin = f"/{token}/"
            known = host in (HERE, "localhost") and self.path.startswith(begin)
            return self.path.removeprefix(begin) if known else None

        def _send(self, text: str, kind: str) -> None:
            content = text.encode()
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", f"{kind}; charset=utf-8")
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(content)

        def _refuse(self) -> None:
            self.send_error(HTTPStatus.NOT_FOUND)

        def _stream(self) -> None:
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", "text/event-stream")
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.close_connection = True
            with suppress(ConnectionError):
                for version in run.versions():
                    self.wfile.write(f"data: {version}\n\n".encode())
                    self.wfile.flush()

    return Handler
