"""Where names and types are wrong, so that no conclusions are drawn from the text there."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.syntax.nodes import Node, Span


class PoisonedSpans:
    """The places of errors."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        errors = [each.span for each in diagnostics if each.severity == "error"]
        self._places = sorted(map(_start, errors))

    def within(self, node: Node | None) -> bool:
        """Return whether an error begins inside the node."""
        if node is None or not node.span.line:
            return False
        span = node.span
        index = bisect_left(self._places, _start(span))
        end = str(span.path), span.end_line, span.end_column
        return index < len(self._places) and self._places[index] < end


def _start(span: Span) -> tuple[str, int, int]:
    return str(span.path), span.line, span.column
