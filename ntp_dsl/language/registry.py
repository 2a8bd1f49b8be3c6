"""A checked library: its declarations by name, who may call whom, and the hash of each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from inspect import unwrap
from typing import Any, TypeVar

from ntp_dsl.common.text import counted
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.syntax import nodes

Value = TypeVar("Value")


@dataclass(frozen=True)
class Parameter:
    """A typed parameter; of a list, `type` is the elements', which only a demonstration shows."""

    name: str
    type: str
    is_list: bool = False
    low: float | None = None
    high: float | None = None


UNBOUNDED = (0.0, 1.0)  # the range of a number that declares none, in SI units


def bounds(parameter: Parameter) -> tuple[float, float]:
    """Return the range of a number, in SI units."""
    if parameter.low is None or parameter.high is None:
        return UNBOUNDED
    return parameter.low, parameter.high


@dataclass(frozen=True)
class Callable:
    """What programs and apis share: a signature and a contract."""

    name: str
    parameters: tuple[Parameter, ...]
    requires: nodes.Expression | None
    achieves: nodes.Expression | None
    hash: str
    docstring: str = ""
    says: tuple[str, ...] = ()  # sentences for its call, with parameters in braces
    span: nodes.Span = field(default=nodes.NOWHERE, compare=False, repr=False)

    def bind(self, arguments: Iterable[Value]) -> dict[str, Value]:
        """Return the arguments of a call by the names of its parameters."""
        return dict(zip((parameter.name for parameter in self.parameters), arguments, strict=True))

    @property
    def takes_list(self) -> bool:
        return any(parameter.is_list for parameter in self.parameters)


@dataclass(frozen=True)
class Api(Callable):
    """A primitive: carried out by the world's `skill`, or by a function in Python."""

    skill: str = ""


@dataclass(frozen=True)
class Program(Callable):
    """A reactive program. `callees` are those that it may call, each once, in its body's order."""

    body: tuple[nodes.Statement, ...] = ()
    callees: tuple[str, ...] = ()
    in_python: bool = False

    def statements(self) -> Iterator[nodes.Call]:
        """Yield the calls of its body, without the loops and conditions around them."""
        for statement in self.body:
            while not isinstance(statement, nodes.Call):
                statement = statement.body
            yield statement

    def line(self, callee: str | None = None) -> str:
        """Return where it first calls something, as `file:line`; else where it is declared."""
        calls = (each.span for each in self.statements() if each.callee == callee)
        span = next(calls, self.span)
        return f"{span.path.name}:{span.line}" if span.path else ""


@dataclass
class PythonCode:
    """The functions that a library leaves to Python; none until `user_code` has imported them."""

    functions: dict[tuple[str, str], Any] = field(default_factory=dict)  # by kind and name

    def get(self, kind: str, name: str) -> Any:
        """Return a function; raise `NtpError` where the user's file was not imported."""
        if (kind, name) not in self.functions:
            raise NtpError(f"the {kind} '{name}' is left to Python, and that was not imported")
        return self.functions[kind, name]


def place_of(function: Any) -> str:
    """Return where a function in Python is defined, as `file:line`."""
    code = getattr(unwrap(function), "__code__", None)
    return f"{code.co_filename}:{code.co_firstlineno}" if code else "?"


@dataclass(frozen=True, repr=False)
class Registry:
    """A checked library: there is none of a library with errors."""

    name: str
    parents: Mapping[str, str | None]  # type -> its parent
    enums: Mapping[str, tuple[str, ...]]
    records: Mapping[str, tuple[Parameter, ...]]
    constants: Mapping[str, str]  # name -> type
    predicates: Mapping[str, nodes.PredicateDeclaration]
    apis: Mapping[str, Api]
    programs: Mapping[str, Program]
    tasks: Mapping[str, nodes.TaskDeclaration]
    python: PythonCode = field(default_factory=PythonCode, compare=False, repr=False)

    def __repr__(self) -> str:
        counts = {"program": self.programs, "api": self.apis, "task": self.tasks}
        listing = ", ".join(counted(len(rows), word) for word, rows in counts.items())
        return f"<Registry {self.name}: {listing}>"

    def __getitem__(self, name: str) -> Program | Api:
        return self.programs.get(name) or self.apis[name]

    def __contains__(self, name: str) -> bool:
        return name in self.programs or name in self.apis

    def ancestors(self, type_name: str) -> Iterator[str]:
        """Yield the type itself, then its parent, and so on to the root."""
        current: str | None = type_name
        while current is not None:
            yield current
            current = self.parents.get(current)

    def is_a(self, type_name: str, ancestor: str) -> bool:
        return ancestor in self.ancestors(type_name)

    def takes(self, wanted: Parameter, given: Parameter) -> bool:
        """Return whether what one parameter holds may be handed on to another, lists aside."""
        is_object = given.type in self.parents and wanted.type in self.parents
        return self.is_a(given.type, wanted.type) if is_object else given.type == wanted.type

    def is_number(self, type_name: str) -> bool:
        """Return whether a type is of numbers: of no objects, members or records."""
        return not any(type_name in each for each in (self.parents, self.enums, self.records))

    def called_by(self, program: str) -> set[str]:
        """Return a program, and all that it calls, directly or not."""
        found, waiting = {program}, [program]
        while waiting:
            row = self.programs.get(waiting.pop())
            new = {*(row.callees if row is not None else ())} - found
            found |= new
            waiting += new
        return found

    @cached_property
    def composed(self) -> frozenset[str]:
        """The predicates that have a body, which is not about themselves."""
        return frozenset(name for name, each in self.predicates.items() if each.body is not None)

    @cached_property
    def hash(self) -> str:
        """The hash of every program and api, without scenes, tasks, goals, comments and layout."""
        from hashlib import sha256

        rows = sorted([*self.programs.values(), *self.apis.values()], key=lambda row: row.name)
        return sha256("".join(f"{row.name}={row.hash};" for row in rows).encode()).hexdigest()[:16]
