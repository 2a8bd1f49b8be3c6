"""From a registry to the graph of its calls: tasks, programs and apis, and how one calls another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.registry import Api, Callable, Parameter, Program, Registry
from ntp_dsl.language.syntax.formatter import format_expression
from ntp_dsl.language.syntax.nodes import Call, For, Statement, TaskDeclaration

Edge = tuple[str, str, str]  # caller, callee, and what is around the call: "for b in Object if ..."


@dataclass(frozen=True)
class Node:
    """A task, program or api; `key` tells a task from a program of the same name."""

    key: str
    kind: str
    name: str
    signature: str
    contract: tuple[str, ...] = ()
    docstring: str = ""

    @property
    def summary(self) -> str:
        """The first paragraph of the docstring, on one line."""
        return " ".join(self.docstring.split("\n\n")[0].split())


@dataclass(frozen=True)
class CallGraph:
    """Who calls whom in a library."""

    name: str
    nodes: tuple[Node, ...]  # tasks, then programs from the roots down, then apis
    edges: tuple[Edge, ...]

    def node(self, key: str) -> Node:
        return next(node for node in self.nodes if node.key == key)

    def calls(self, key: str) -> Iterator[tuple[Node, str]]:
        """Yield what a node calls, in its order, and what is around each call."""
        for caller, callee, label in self.edges:
            if caller == key:
                yield self.node(callee), label

    def roots(self) -> list[Node]:
        """Return what nothing else calls; where all call one another in a cycle, the first."""
        called = {callee for caller, callee, _ in self.edges if callee != caller}
        return [node for node in self.nodes if node.key not in called] or [*self.nodes[:1]]


def call_graph(registry: Registry, program: str | None = None) -> CallGraph:
    """Return the library's tasks and its own programs with all that they call, or one program with that.

    Raises `NtpError` where there is no such program.
    """
    if program is None:
        tasks = list(registry.tasks.values())
        starts = [task.run.callee for task in tasks if task.run] + _own(registry)
    elif program in registry:
        tasks, starts = [], [program]
    else:
        meant = nearest(program, [*registry.programs, *registry.apis])
        guess = f"; did you mean '{meant}'?" if meant else ""
        listing = ", ".join(registry.programs)
        raise NtpError(f"library '{registry.name}' has no program '{program}'{guess} (there is: {listing})")
    reached = _reached(registry, starts)
    nodes = [_task(task) for task in tasks]
    nodes += [_node(registry[name]) for name in reached if name in registry.programs]
    nodes += [_node(registry[name]) for name in reached if name in registry.apis]
    edges = [(f"task {task.name}", task.run.callee, "") for task in tasks if task.run]
    edges += [edge for name in reached for edge in _edges(registry[name])]
    return CallGraph(registry.name, tuple(nodes), tuple(edges))


def _own(registry: Registry) -> list[str]:
    """Return the programs of the library itself, or all where it cannot be told which those are."""
    paths = [each.name_span.path for each in registry.tasks.values()]
    own = [each.name for each in registry.programs.values() if each.span.path in paths]
    return own or ([] if paths else [*registry.programs, *registry.apis])


def _reached(registry: Registry, starts: Sequence[str]) -> list[str]:
    found: dict[str, None] = {}
    waiting = list(reversed(starts))
    while waiting:
        name = waiting.pop()
        if name not in found:
            found[name] = None
            row = registry[name]
            waiting += reversed(row.callees) if isinstance(row, Program) else []
    return list(found)


def _task(task: TaskDeclaration) -> Node:
    return Node(f"task {task.name}", "task", task.name, task.name, (), task.docstring)


def _node(row: Program | Api) -> Node:
    kind = "program" if isinstance(row, Program) else "api"
    signature = f"{row.name}({', '.join(map(_parameter, row.parameters))})"
    return Node(row.name, kind, row.name, signature, _contract(row), row.docstring)


def _parameter(parameter: Parameter) -> str:
    type = f"list[{parameter.type}]" if parameter.is_list else parameter.type
    return f"{parameter.name}: {type}"


def _contract(row: Callable) -> tuple[str, ...]:
    clauses = {"requires": row.requires, "achieves": row.achieves}
    return tuple(f"{word} {format_expression(value)}" for word, value in clauses.items() if value)


def _edges(row: Program | Api) -> Iterator[Edge]:
    """Yield each callee once, with what is around the first call of it."""
    if not isinstance(row, Program):
        return
    labels: dict[str, str] = {}
    for statement in row.body:
        callee, label = _call(statement)
        labels.setdefault(callee, label)
    for callee in row.callees:
        yield row.name, callee, labels.get(callee, "in Python")


def _call(statement: Statement) -> tuple[str, str]:
    around = []
    while not isinstance(statement, Call):
        if isinstance(statement, For):
            loop = statement.generator
            head = f"for {loop.variable} in {loop.iterable.id}"
            if loop.condition is not None:
                head += f" if {format_expression(loop.condition)}"
            around.append(head)
        else:
            around.append(f"when {format_expression(statement.condition)}")
        statement = statement.body
    return statement.callee, ": ".join(around)
