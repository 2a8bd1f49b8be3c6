"""Whoever supervises a running program: waits before a decision is carried out, or forces an outcome."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, cast

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.registry import Callable, Registry
from ntp_dsl.policies.protocol import Choice, Frame
from ntp_dsl.semantics.observation import Argument, DeclaredFact, Observation
from ntp_dsl.semantics.predicates import ANY
from ntp_dsl.traces.phrases import format_argument
from ntp_dsl.worlds.protocol import ACHIEVED, Failure, Outcome, World

FORCED = "forced"  # as a disturbance of a trace
OUTCOMES = {"achieved": ACHIEVED, **{each.name.lower(): Outcome(False, each) for each in Failure}}
CALL = re.compile(r"(\w+)(?:\((.*)\))?")
VALUE = re.compile(r"[\[(]|-?[\d.]+(e-?\d+)?$")  # a list, a record or a number
COMMA = re.compile(r",(?![^\[(]*[\])])")  # outside of brackets


class Supervisor(Protocol):
    """Someone who may stop a program before a decision is carried out, and who may force an outcome."""

    def before(self, depth: int, frame: Frame, choice: Choice) -> None:
        """Return when a decision may be carried out.

        Args:
            depth: number of programs that are running.
            frame: of the program that decided.
            choice: its decision, with what it rests on.
        """

    def outcome(self, callee: str, arguments: tuple[Argument, ...]) -> Outcome | None:
        """Return what a primitive comes to without being carried out; None to carry it out."""

    def world(self, frame: Frame, world: World) -> World:
        """Return the world that a program's decision is made by: as it is, or with facts that are forced."""


@dataclass(frozen=True)
class CallPattern:
    """A callee, with its arguments or with any."""

    callee: str
    arguments: tuple[str, ...] | None = None  # as text, without spaces; None for any

    @classmethod
    def parse(cls, text: str, known: Mapping[str, Callable]) -> CallPattern | None:
        """Return what `grasp` or `grasp(block_3)` means; None for what is neither, or not known.

        Raises `NtpError` for a wrong number of arguments.
        """
        found = CALL.fullmatch(text.strip())
        if found is None or found[1] not in known:
            return None
        if found[2] is None:
            return cls(found[1])
        given = found[2].replace(" ", "")
        arguments = tuple(COMMA.split(given)) if given else ()
        parameters = known[found[1]].parameters
        if len(arguments) != len(parameters):
            names = ", ".join(each.name for each in parameters)
            raise NtpError(f"'{text}': {found[1]} takes ({names}), found {len(arguments)} arguments")
        return cls(found[1], arguments)

    def matches(self, callee: str, arguments: tuple[Argument, ...]) -> bool:
        """Return whether a call is meant."""
        if callee != self.callee:
            return False
        return self.arguments is None or self.arguments == tuple(map(_plain, arguments))

    def __str__(self) -> str:
        return self.callee if self.arguments is None else f"{self.callee}({', '.join(self.arguments)})"


def _plain(argument: Argument) -> str:
    return format_argument(argument).replace(" ", "")


@dataclass(frozen=True)
class Injection:
    """An outcome that is forced on a primitive, once."""

    call: CallPattern
    outcome: Outcome

    @classmethod
    def parse(cls, text: str, registry: Registry) -> Injection:
        """Return what `grasp(block_3)=object_dropped` says. Raises `NtpError` for anything else."""
        given, equals, name = (part.strip() for part in text.rpartition("="))
        outcome = OUTCOMES.get(name)
        if not equals or outcome is None:
            hint = _near(name, OUTCOMES) if equals else ""
            expected = "--inject: expected CALL=OUTCOME, such as grasp(block_3)=object_dropped"
            known = f"outcomes are {', '.join(OUTCOMES)}; of a fact, true and false"
            raise NtpError(f"{expected}, found '{text}'{hint}; {known}")
        call = CallPattern.parse(given, registry.apis)
        if call is None:
            hint = _near(given.partition("(")[0], registry.apis)
            raise NtpError(f"--inject: '{given}' is no call of an api of library '{registry.name}'{hint}")
        return cls(call, outcome)


@dataclass(frozen=True)
class ForcedFact:
    """A fact that is seen to hold, or not to, whatever is the case: in all decisions, or a program's."""

    text: str
    fact: DeclaredFact
    holds: bool
    node: CallPattern | None = None

    @classmethod
    def parse(cls, text: str, registry: Registry) -> ForcedFact:
        """Return what `clear(b)=false` or `pick(a): clear(b)=false` says. Raises `NtpError` for all else."""
        given, _, value = (part.strip() for part in text.rpartition("="))
        before, colon, fact = (part.strip() for part in given.rpartition(":"))
        node = CallPattern.parse(before, registry.programs) if colon else None
        if colon and node is None:
            hint = _near(before.partition("(")[0], registry.programs)
            what = f"'{before}' is no call of a program of library '{registry.name}'"
            raise NtpError(f"--inject: {what}{hint}")
        found = CALL.fullmatch(fact)
        declared = registry.predicates.get(found[1]) if found else None
        if found is None or declared is None or declared.result is not None:
            hint = _near(fact.partition("(")[0], registry.predicates)
            raise NtpError(f"--inject: '{fact}' is no fact of library '{registry.name}'{hint}")
        arguments = tuple(each.strip() for each in (found[2] or "").split(",") if each.strip())
        if len(arguments) != len(declared.parameters):
            names = ", ".join(each.name for each in declared.parameters)
            raise NtpError(f"'{text}': {found[1]} takes ({names}), found {len(arguments)} arguments")
        return cls(text, DeclaredFact(found[1], arguments), value == "true", node)


def check_names(
    option: str, text: str, names: Iterable[str], registry: Registry, objects: Iterable[str]
) -> None:
    """Raise `NtpError` where what an option says is about an object that is not in the scene.

    Args:
        objects: the names of those that are.
    """
    members = {member for enum in registry.enums.values() for member in enum}
    known = {*objects, *registry.constants, *members, ANY}
    for name in names:
        if not VALUE.match(name) and name not in known:
            raise NtpError(f"{option}: '{name}' in '{text}' is no object of the scene{_near(name, known)}")


def _near(name: str, known: Iterable[str]) -> str:
    near = nearest(name, known)
    return f"; did you mean '{near}'?" if near else ""


class _Forced(dict[DeclaredFact, bool]):
    """Facts as they are forced to be, which note what is asked about."""

    def __init__(self, facts: Mapping[DeclaredFact, bool], asked: set[DeclaredFact]) -> None:
        super().__init__(facts)
        self._asked = asked

    def get(self, fact: DeclaredFact, default: Any = None) -> Any:
        self._asked.add(fact)
        return super().get(fact, default)


@dataclass
class _Misled:
    """A world of which some facts are seen as they are forced to be; all else is the world's own."""

    _world: World
    _forced: _Forced

    def __getattr__(self, name: str) -> Any:
        return getattr(self._world, name)

    def observe(self) -> Observation:
        return replace(self._world.observe(), forced=self._forced)

    def truth(self) -> Observation:
        return replace(self._world.truth(), forced=self._forced)


class Injections:
    """Forces each outcome on the first primitive that it fits, and facts on what is seen.

    Args:
        objects: the names of those in the scene.

    Raises `NtpError` for a text that says neither `CALL=OUTCOME` nor `FACT=true`, or names another object.
    """

    def __init__(self, texts: Sequence[str], registry: Registry, objects: Sequence[str]) -> None:
        is_fact = [text.rpartition("=")[2].strip() in ("true", "false") for text in texts]
        told = [*zip(texts, is_fact, strict=True)]
        self.waiting = [Injection.parse(text, registry) for text, fact in told if not fact]
        self._facts = [ForcedFact.parse(text, registry) for text, fact in told if fact]
        for call in self.waiting:
            check_names("--inject", str(call.call), call.call.arguments or (), registry, objects)
        for fact in self._facts:
            named = fact.node.arguments or () if fact.node is not None else ()
            check_names("--inject", fact.text, (*named, *fact.fact.arguments), registry, objects)
        self.unseen = [*self._facts]  # that no decision was made with
        self._asked: set[DeclaredFact] = set()  # about which decisions asked

    def __bool__(self) -> bool:
        return bool(self.waiting or self._facts)

    def world(self, frame: Frame, world: World) -> World:
        """Return the world as a program is to see it."""
        wanted = [
            each
            for each in self._facts
            if each.node is None or each.node.matches(frame.program, frame.arguments)
        ]
        if not wanted:
            return world
        for each in wanted:
            if each in self.unseen:
                self.unseen.remove(each)
        forced = _Forced({each.fact: each.holds for each in wanted}, self._asked)
        return cast(World, _Misled(world, forced))

    @property
    def unread(self) -> list[ForcedFact]:
        """The facts that decisions were made with, and about which none asked."""
        return [each for each in self._facts if each not in self.unseen and each.fact not in self._asked]

    def outcome(self, callee: str, arguments: tuple[Argument, ...]) -> Outcome | None:
        """Return the forced outcome of a primitive, marked as such, or None."""
        for each in self.waiting:
            if each.call.matches(callee, arguments):
                self.waiting.remove(each)
                return Outcome(each.outcome.achieved, each.outcome.failure, disturbances=(FORCED,))
        return None
