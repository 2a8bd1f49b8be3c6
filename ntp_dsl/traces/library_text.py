"""What the library says, read from the copy that a trace carries: its statements, and loops over nothing."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.logic.facts import bind, substitute
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.language.syntax import nodes
from ntp_dsl.language.syntax.formatter import format_expression, format_statement
from ntp_dsl.language.syntax.visitors import callees, innermost, loops
from ntp_dsl.traces.trace import Trace

LONGEST = 200  # characters of a statement


def statement_text(trace: Trace, program: str, line: int) -> str:
    """Return a program's statement at a line, with what it is to achieve; empty where it is lacking."""
    text = _Text(trace)
    for each in text.body(program):
        if each.span.line == line:
            written = " ".join(row.strip() for row in format_statement(each))[:LONGEST]
            achieved = text.achieved(innermost(each))
            return f"`{written}`" + (f", which achieves `{achieved[:LONGEST]}`" if achieved else "")
    return ""


def statement_lines(text: str) -> set[int]:
    """Return the lines of a library's programs: of their headers, and of their statements."""
    library = _parsed(text)
    programs = (
        [each for each in library.declarations if isinstance(each, nodes.ProgramDeclaration)]
        if library
        else []
    )
    return {
        span.line for each in programs for span in (each.span, *(innermost(row).span for row in each.body))
    }


def in_python(trace: Trace, predicate: str) -> bool:
    """Return whether a function in Python tells whether facts of a predicate hold."""
    declared = _Text(trace).declared.get(predicate)
    by = declared.by if isinstance(declared, nodes.PredicateDeclaration) else None
    return by is not None and by.id == nodes.PYTHON


def empty_loops(trace: Trace) -> Iterator[tuple[str, str, int]]:
    """Yield the type, the program and the line of each loop over no object, of what the run may call."""
    text = _Text(trace)
    absent = text.types - text.present({each.type for each in trace.header.objects})
    for name in sorted(text.reachable({call.name for call in trace.calls})):
        for loop in (each for statement in text.body(name) for each in loops(statement)):
            if loop.iterable.id in absent:
                yield loop.iterable.id, name, loop.span.line


class _Text:
    """The declarations of the libraries that a trace carries, as far as they can be read."""

    def __init__(self, trace: Trace) -> None:
        libraries = [library for text in trace.header.sources.values() if (library := _parsed(text))]
        self.declared = {each.name: each for library in libraries for each in library.declarations}
        types = [each for each in self.declared.values() if isinstance(each, nodes.TypeDeclaration)]
        self.types = {each.name for each in types}
        self._parents = {each.name: each.parent.name for each in types if each.parent}

    def body(self, program: str) -> tuple[nodes.Statement, ...]:
        found = self.declared.get(program)
        return found.body if isinstance(found, nodes.ProgramDeclaration) else ()

    def achieved(self, call: nodes.Call) -> str:
        """Return what a call is to achieve, in the words of its caller."""
        callee = self.declared.get(call.callee)
        if not isinstance(callee, nodes.ProgramDeclaration | nodes.ApiDeclaration) or callee.achieves is None:
            return ""
        return format_expression(substitute(callee.achieves, bind(callee.parameters, call.arguments)))

    def present(self, types: set[str]) -> set[str]:
        """Return some types, and all that these are."""
        found: set[str] = set()
        for name in types:
            while name and name not in found:
                found.add(name)
                name = self._parents.get(name, "")
        return found

    def reachable(self, programs: set[str]) -> set[str]:
        """Return some programs, and all that these may call."""
        found: set[str] = set()
        ahead = [*programs]
        while ahead:
            name = ahead.pop()
            program = self.declared.get(name)
            if name not in found and isinstance(program, nodes.ProgramDeclaration):
                found.add(name)
                ahead += callees(program)
        return found


@lru_cache(maxsize=16)
def _parsed(text: str) -> nodes.Library | None:
    try:
        return parse(text)
    except NtpError:  # of another version of the language
        return None
