"""Merging a repeated clause into the first one."""

from __future__ import annotations

from ntp_dsl.language.diagnostics.diagnostics import Edit, Fix
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Span


def merge_clauses(first: object, again: object, before: Span, place: Span) -> Fix | None:
    """Remove the second clause, with the line break before it, and add what it says to the first.

    Args:
        before: where the clause stands that comes before the second; `place` is where that stands.
    """
    rest = Span(place.path, before.end_line, before.end_column, place.end_line, place.end_column)
    if first == again:
        return Fix(rest, "")
    last = first.values[-1] if isinstance(first, nodes.And) else first
    if not isinstance(last, nodes.Atom | nodes.Not) or not isinstance(again, nodes.Atom):
        return None
    end = last.span
    whole = Span(end.path, end.end_line, end.end_column, end.end_line, end.end_column)
    return Fix(rest, "", (Edit(whole, f" and {format_expression(again)}"),))
