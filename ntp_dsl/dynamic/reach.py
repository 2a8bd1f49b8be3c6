"""The executable part of a library: without Python that is not loaded, or what the world lacks."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import cached_property

from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.language.syntax.nodes import Expression, Span, TaskDeclaration
from ntp_dsl.language.syntax.visitors import guards, innermost, predicates
from ntp_dsl.user_code.loading import needed


class Reach:
    """Finds what cannot be executed, and everything that depends on it."""

    def __init__(self, registry: Registry, lacking: Collection[str]) -> None:
        self._registry = registry
        self._lacking = set(lacking)
        self._python = {
            (kind, name): span
            for kind, name, span, _ in needed(registry)
            if (kind, name) not in registry.python.functions
        }

    def not_executed(self) -> Iterator[Diagnostic]:
        """Yield a note for each declaration that is not executed."""
        for (kind, name), span in self._python.items():
            message = f"not executed: the {kind} '{name}' is written in Python"
            help = "to import it and test what depends on it: ntp check --execute"
            yield Diagnostic("N601", message, span, (), help)
        for name in sorted(self._lacking):
            message = f"not executed: the kinematic world does not implement '{name}'"
            help = "write a function of that name in Python, and declare it with: by python"
            yield Diagnostic("N602", message, self.place(name) or self._anywhere, (), help)

    @cached_property
    def _anywhere(self) -> Span:
        return next(iter(self._registry.programs.values())).span

    def place(self, name: str) -> Span | None:
        """Return the location of a declaration."""
        registry = self._registry
        for rows in (registry.programs, registry.apis):
            if name in rows:
                return rows[name].span
        for declared in (registry.tasks, registry.predicates):
            if name in declared:
                return declared[name].name_span
        return None

    def runnable(self) -> Registry:
        """Return the registry without what cannot be executed."""
        registry = self._registry
        programs = {name: row for name, row in registry.programs.items() if name not in self._blocked}
        return replace(
            registry,
            apis={name: row for name, row in registry.apis.items() if name not in self._blocked},
            programs=programs,
            predicates={n: row for n, row in registry.predicates.items() if n not in self._unknown},
            tasks={name: task for name, task in registry.tasks.items() if self._can_run(task, programs)},
        )

    def _can_run(self, task: TaskDeclaration, programs: Collection[str]) -> bool:
        drawn = task.sampler is None or ("sampler", task.sampler.name) not in self._python
        runs = task.run is not None and task.run.callee in programs
        return drawn and runs and not self._uses_unknown(task.success)

    @cached_property
    def _unknown(self) -> set[str]:
        """Predicates that cannot be evaluated, and those composed of them."""
        unknown = {name for kind, name in self._python if kind == "predicate"} | self._lacking
        while True:
            more = {
                name
                for name, declared in self._registry.predicates.items()
                if name not in unknown and predicates(declared.body) & unknown
            }
            if not more:
                return unknown
            unknown |= more

    def _uses_unknown(self, expression: Expression | None) -> bool:
        return bool(predicates(expression) & self._unknown)

    def _body_uses_unknown(self, program: Program) -> bool:
        """Whether a loop, a `when` or an argument in its body uses an unknown predicate."""
        return any(
            self._uses_unknown(expression)
            for statement in program.body
            for expression in (*guards(statement), *innermost(statement).arguments)
        )

    @cached_property
    def _blocked(self) -> set[str]:
        """Programs and apis that cannot be executed, and those that call one."""
        registry = self._registry
        blocked = {name for kind, name in self._python if kind in ("expert", "skill")}
        blocked |= self._lacking & set(registry.apis)
        rows = [*registry.apis.values(), *registry.programs.values()]
        blocked |= {
            row.name for row in rows if self._uses_unknown(row.requires) or self._uses_unknown(row.achieves)
        }
        blocked |= {row.name for row in registry.programs.values() if self._body_uses_unknown(row)}
        while True:
            more = {
                name
                for name, row in registry.programs.items()
                if name not in blocked and any(callee in blocked for callee in row.callees)
            }
            if not more:
                return blocked
            blocked |= more
