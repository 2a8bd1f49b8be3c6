"""A page on this machine that shows a run as it happens, and from which it can be stepped."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from queue import Queue
from threading import Condition, Thread
from time import perf_counter
from typing import Any

from ntp_dsl.cli.display import messages
from ntp_dsl.cli.live_runs.looking import pause
from ntp_dsl.cli.shown_beside import demonstration_beside
from ntp_dsl.cli.terminal import has_typist, read_line
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.traces.page.page import encoded, live_document, live_page, waiting_page
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.trace import Trace

HERE = "127.0.0.1"
DRAIN_TIMEOUT = 5.0  # [s] that pages have for fetching the end
LINES = {"step": "\n", "over": "o\n", "go": "c\n"}  # of the page's buttons, as if typed at the terminal


class LiveRun:
    """A run that pages show: its trace, what it waits for, and the lines that say how to go on."""

    def __init__(self, trace: Path) -> None:
        self._path = trace
        self._lines: Queue[str] = Queue()
        self._changed = Condition()  # guards all below
        self._waits_for = ""
        self._has_begun = self._is_over = False
        self._changes = 0
        self._is_asked_for = self._is_followed = False  # by a page, at any time
        self._pages = self._pages_served = 0  # that follow it; that have fetched the end
        self._cost = 0.0  # [s] of the last document
        self._shown: Demonstration | None = None  # once it is there

    # The run's side ---------------------------------------------------------------------------

    def begin(self) -> None:
        """Return when the first page is asked for, or a line was typed, or nobody can type."""
        Thread(target=self._listen, daemon=True).start()
        with self._changed:
            self._changed.wait_for(lambda: self._has_begun)

    def announce(self, waits_for: str) -> None:
        """Show what the run waits for; nothing, where the text is empty."""
        with self._changed:
            self._waits_for = waits_for
            self._changes += 1
            self._changed.notify_all()

    def read_line(self) -> str:
        """Return the next line that was typed at the terminal, or chosen on a page."""
        return self._lines.get()

    def end(self) -> None:
        """Let the pages fetch the end."""
        with self._changed:
            self._is_over = True
            self._changed.notify_all()
            pages = self._pages
            if self._is_asked_for and not self._is_followed:
                pages = 1  # which is only being opened
            self._changed.wait_for(lambda: self._pages_served >= pages, DRAIN_TIMEOUT)

    def _listen(self) -> None:
        """Pass on what is typed, to the end of the input; the first line may begin the run."""
        while line := read_line():
            if not self.start():
                self._lines.put(line)
        self.start()
        if has_typist():
            self._lines.put("")  # else a page may still say how to go on

    # The pages' side --------------------------------------------------------------------------

    def open(self) -> None:
        """Begin the run, as a page is asked for."""
        with self._changed:
            self._is_asked_for = True
        self.start()

    def start(self) -> bool:
        """Begin the run; return whether that was still to be done."""
        with self._changed:
            starts, self._has_begun = not self._has_begun, True
            self._changed.notify_all()
        return starts

    def submit(self, line: str) -> bool:
        """Go on as a page says; return False where the run does not wait."""
        with self._changed:
            if not self._waits_for:
                return False
            self._waits_for = ""
        self._lines.put(line)
        return True

    def versions(self) -> Iterator[int | None]:
        """Yield a number whenever there is something new, the last one at the run's end; else None."""
        with self._changed:
            self._pages, self._is_followed = self._pages + 1, True
            self._changed.notify_all()
        try:
            last = None
            while True:
                with self._changed:
                    changes, over = self._changes, self._is_over
                now = changes, over, self._path.stat().st_size if self._path.is_file() else 0
                yield changes if now != last else None
                last = now
                if over:
                    return
                with self._changed:
                    self._changed.wait(pause(self._cost))
        finally:
            with self._changed:
                self._pages -= 1

    def page(self) -> str:
        """Return the page of what there is so far. Raises `NtpError` where that is nothing."""
        trace, shown = self._read()
        return live_page(trace, self._path.parent, shown)

    def document(self) -> tuple[str, bool]:
        """Return what the page is to show now, as JSON, and whether that is the end.

        Raises `NtpError` as `page` does.
        """
        with self._changed:
            waits_for, over = self._waits_for, self._is_over
        started = perf_counter()
        trace, shown = self._read()
        text = encoded(live_document(trace, self._path.parent, shown, waits_for, goes_on=not over))
        self._cost = perf_counter() - started
        return text, over

    def served(self, is_end: bool) -> None:
        """Note that a page has fetched a document."""
        with self._changed:
            self._pages_served += is_end
            self._changed.notify_all()

    def _read(self) -> tuple[Trace, Demonstration | None]:
        trace = read_trace(self._path)
        if self._shown is None:
            self._shown = demonstration_beside(trace, self._path)
        return trace, self._shown


@contextmanager
def live(trace: Path) -> Iterator[LiveRun]:
    """Serve pages of a run while it goes on, at an address that nobody can guess."""
    run = LiveRun(trace)
    server = ThreadingHTTPServer((HERE, 0), _handler(run, token := secrets.token_urlsafe(12)))
    server.daemon_threads = True
    Thread(target=server.serve_forever, daemon=True).start()
    messages.print(f"watch it at http://{HERE}:{server.server_port}/{token}/ (Enter begins without a page)")
    try:
        yield run
    finally:
        run.end()
        server.shutdown()
        server.server_close()


def _handler(run: LiveRun, token: str) -> type[BaseHTTPRequestHandler]:
    """Return what answers requests; without the token, nothing is found."""

    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self) -> None:
            try:
                match self._asked():
                    case "":
                        run.open()
                        self._send(run.page(), "text/html")
                    case "document":
                        text, is_end = run.document()
                        self._send(text, "application/json")
                        run.served(is_end)
                    case "events":
                        self._stream()
                    case _:
                        self._refuse()
            except NtpError:  # there is no whole line yet, or one is being written
                if self._asked():
                    self._refuse(HTTPStatus.SERVICE_UNAVAILABLE)
                else:
                    self._send(waiting_page(), "text/html")
            except ConnectionError:
                self.close_connection = True  # the page was closed

        def do_POST(self) -> None:
            line = LINES.get(self._asked() or "")
            if line is None:
                self._refuse()
            elif run.submit(line):
                self._send("", "text/plain")
            else:
                self._refuse(HTTPStatus.CONFLICT)

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

        def _refuse(self, status: HTTPStatus = HTTPStatus.NOT_FOUND) -> None:
            self.send_error(status)

        def _stream(self) -> None:
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", "text/event-stream")
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.close_connection = True
            with suppress(ConnectionError):
                for version in run.versions():  # a comment shows whether the page is still there
                    self.wfile.write(b":\n\n" if version is None else f"data: {version}\n\n".encode())
                    self.wfile.flush()

    return Handler
