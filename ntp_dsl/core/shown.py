"""Where the lists of running programs come from: read from a demonstration, or told in so many words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from ntp_dsl.core.perception.grounding import Grounding, ground_all
from ntp_dsl.core.perception.perceived import Perceived
from ntp_dsl.core.perception.steadied import steadied
from ntp_dsl.core.reading.candidates import Element
from ntp_dsl.core.reading.moments import Moments
from ntp_dsl.core.reading.reader import Reader
from ntp_dsl.core.reading.reading import Doubt, Reading
from ntp_dsl.demonstrations.demonstration import Demonstration, Scope
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.evidence import rounded
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.protocol import Frame
from ntp_dsl.policies.scripted import alike, counterpart, like_calls
from ntp_dsl.semantics.observation import Argument, Observation, without_lists
from ntp_dsl.traces import decision as traced
from ntp_dsl.traces.schema import DemonstratedCall

Arguments = tuple[Argument, ...]


class Source(Protocol):
    """Gives running programs their lists and scopes."""

    def perceive(self, seen: Observation) -> Perceived: ...

    def scope(self) -> Scope | None:
        """Return the scope of the root."""

    def passed_on(self, arguments: Arguments) -> Arguments:
        """Return the arguments of a call as they are handed to it."""

    def arguments(self, frame: Frame) -> Arguments | None:
        """Return the arguments of a running program, lists included; None where nothing shows its lists."""

    def scope_of(self, frame: Frame, callee: str, arguments: Arguments) -> Scope | None:
        """Return the frames that show a program's call."""

    def certainty(self, frame: Frame, arguments: Arguments | None) -> float:
        """Return how probable it is that a running program has read its lists rightly.

        Args:
            arguments: of a call, whose elements alone count; None for all that the program has read.
        """

    def told(self, frame: Frame) -> traced.Reading | None:
        """Return, once, what a running program reads of its lists."""


class Told:
    """Lists are handed on as they were given. There is no demonstration, and there are no scopes.

    Args:
        probability: that the lists are what was meant.
    """

    def __init__(self, registry: Registry, network: Grounding, probability: float = 1.0) -> None:
        self.registry, self._network, self._probability = registry, network, probability

    def perceive(self, seen: Observation) -> Perceived:
        return Perceived(self.registry, seen, self._network)

    def scope(self) -> Scope | None:
        return None

    def passed_on(self, arguments: Arguments) -> Arguments:
        return arguments

    def arguments(self, frame: Frame) -> Arguments:
        return frame.arguments

    def scope_of(self, frame: Frame, callee: str, arguments: Arguments) -> Scope | None:
        return None

    def certainty(self, frame: Frame, arguments: Arguments | None) -> float:
        return self._probability if frame.matched is None else 1.0  # it counts once, at the root

    def told(self, frame: Frame) -> traced.Reading | None:
        return None


class Shown:
    """A demonstration: each program that takes lists reads them from its own scope of it.

    Where the list that its caller has read explains as much of that scope, it is that one.

    Args:
        whole_scopes: from all of it instead, to measure what scopes are good for.
        expert: by whose decisions the demonstration is explained; by the bodies' own where it is None.
    """

    def __init__(
        self,
        registry: Registry,
        demonstration: Demonstration,
        network: Grounding,
        whole_scopes: bool = False,
        expert: Expert | None = None,
    ) -> None:
        self.registry, self.demonstration, self._network = registry, demonstration, network
        self._whole_scopes = whole_scopes
        self.expert = expert or Expert(registry)
        self._states = steadied(demonstration)
        self._moments = Moments(self._states, (0, len(demonstration)), self._perceive_all)
        self._readings: dict[tuple[str, Arguments, Scope], Reading] = {}
        self._handed: dict[tuple[str, Arguments, Scope], Arguments] = {}  # as their callers have read them
        self._answers: dict[tuple[int, frozenset[Element]], Element] = {}  # to doubts, by frame and offer
        self._told: set[tuple[str, Arguments, Scope]] = set()  # readings that a trace has

    def perceive(self, seen: Observation) -> Perceived:
        return Perceived(self.registry, seen, self._network)

    def _perceive_all(self, seen: Sequence[Observation]) -> list[Perceived]:
        states = [self.perceive(each) for each in seen]
        for state, graded in zip(states, ground_all(self._network, seen), strict=True):
            state.graded = graded
        return states

    def look(self, frame: int) -> Observation:
        """Return the state that a frame shows."""
        return self._states.observation(frame)

    def scope(self) -> Scope:
        return 0, len(self.demonstration)

    def passed_on(self, arguments: Arguments) -> Arguments:
        """Return the arguments without what their lists hold: programs read those, or what callers read."""
        return without_list_values(arguments)

    def arguments(self, frame: Frame) -> Arguments | None:
        if not self.registry.programs[frame.program].takes_list:
            return frame.arguments
        if frame.scope is None:
            return None
        return self.reading(frame.program, frame.arguments, frame.scope).arguments

    def scope_of(self, frame: Frame, callee: str, arguments: Arguments) -> Scope | None:
        if self._whole_scopes:
            return self.scope()
        caller = self._call(frame)
        declared = self.registry.programs.get(callee)
        if caller is not None and declared is not None and declared.takes_list:
            scope = hull(caller, callee, arguments) or frame.scope  # where its own call is not made out
            if scope is not None:
                self._handed[callee, without_list_values(arguments), scope] = arguments
            return scope
        call = counterpart(caller, callee, arguments)
        return call.scope if call is not None else None

    def certainty(self, frame: Frame, arguments: Arguments | None) -> float:
        if frame.scope is None or not self.registry.programs[frame.program].takes_list:
            return 1.0
        reading = self.reading(frame.program, frame.arguments, frame.scope)
        if arguments is None:
            return reading.probability
        return reading.certainty([each for each in without_lists(arguments) if isinstance(each, str)])

    def told(self, frame: Frame) -> traced.Reading | None:
        row = self.registry.programs[frame.program]
        if frame.scope is None or not row.takes_list:
            return None
        reading = self.reading(frame.program, frame.arguments, frame.scope)
        key = frame.program, without_list_values(frame.arguments), frame.scope
        if key in self._told:
            return None
        self._told.add(key)
        pairs = zip(row.parameters, reading.arguments, strict=True)
        lists = tuple(
            traced.ReadList(parameter.name, value) for parameter, value in pairs if isinstance(value, tuple)
        )
        doubts = tuple(
            traced.Doubt(
                each.parameter,
                each.number,
                each.element,
                rounded(each.probability),
                tuple(traced.Other(element, rounded(share)) for element, share in each.others),
                each.answer,
            )
            for each in reading.doubts
        )
        return traced.Reading(lists, reading.explained, reading.acts, doubts)

    def reading(self, program: str, arguments: Arguments, scope: Scope) -> Reading:
        """Return what a part of the demonstration says of a program's lists, and which calls it shows."""
        key = program, without_list_values(arguments), scope
        if key not in self._readings:
            reader, found, self._moments = self._read(program, arguments, scope)
            if key in self._handed:
                found = reader.agreeing(found, self._handed[key])
            said = {doubt: answer for doubt in found.doubts if (answer := self._answer(doubt)) is not None}
            self._readings[key] = reader.settled(found, said) if said else found
        return self._readings[key]

    def _read(self, program: str, arguments: Arguments, scope: Scope) -> tuple[Reader, Reading, Moments]:
        """Return a reading, who read it, and the states that it was read from.

        What nothing explains may lie a little elsewhere than it is seen. Only what the root reads is moved.
        """
        moments = self._moments
        reader = self._reader(program, arguments, moments.within(scope))
        found = reader.read()
        for stray in found.strays if scope == self.scope() else ():
            offset = reader.place_of(stray) if stray in found.strays else None
            if offset is None:
                continue
            moved = moments.moved(*offset)
            other = self._reader(program, arguments, moved.within(scope))
            better = other.read()
            if better.explained > found.explained and len(better.strays) < len(found.strays):
                reader, found, moments = other, better, moved
        return reader, found, moments

    def settle(
        self, program: str, arguments: Arguments, scope: Scope, answers: Mapping[Doubt, Element]
    ) -> None:
        """Let lists have the elements that somebody says are meant, of a program and of those it calls.

        Raises `NtpError` where less of the demonstration is explained with them.
        """
        before = self.reading(program, arguments, scope)
        self._answers |= {(doubt.frame, doubt.offered): element for doubt, element in answers.items()}
        self._readings.clear()
        after = self.reading(program, arguments, scope)
        if after.explained < before.explained:
            raise NtpError(
                f"these answers together explain {after.explained} of {after.acts} acts of the hand, and the "
                f"reading before {before.explained}: choose others"
            )

    def _answer(self, doubt: Doubt) -> Element | None:
        """Return which of the elements that a program has in doubt somebody said is meant then."""
        for (frame, offered), element in self._answers.items():
            if frame == doubt.frame and element in doubt.offered and offered & doubt.offered:
                return element
        return None

    def _reader(self, program: str, arguments: Arguments, moments: Moments) -> Reader:
        row = self.registry.programs[program]
        if len(arguments) != len(row.parameters):
            raise NtpError(f"'{program}' takes {len(row.parameters)} arguments, here are {len(arguments)}")
        pairs = zip(row.parameters, arguments, strict=True)
        given = {parameter.name: value for parameter, value in pairs if not parameter.is_list}
        return Reader(self.expert, row, given, moments)

    def _call(self, frame: Frame) -> DemonstratedCall | None:
        """Return the call that shows a running program: the root's, or one below of the same frames."""
        if frame.scope is None:
            return None
        if frame.scope == self.scope() or self.registry.programs[frame.program].takes_list:
            return self.reading(frame.program, frame.arguments, frame.scope).call
        for reading in self._readings.values():
            for call in reading.call.walk():
                same = call.name == frame.program and call.scope == frame.scope
                if same and alike(call.arguments, frame.arguments):
                    return call
        return None


def hull(caller: DemonstratedCall, callee: str, arguments: Arguments) -> Scope | None:
    """Return the frames from the first to the last call of a program of lists, which may be interrupted."""
    scopes = [each.scope for each in like_calls(caller, callee, arguments)]
    return (min(begin for begin, _ in scopes), max(end for _, end in scopes)) if scopes else None


def without_list_values(arguments: Arguments) -> Arguments:
    """Return arguments with nothing in their lists."""
    return tuple(() if isinstance(each, tuple) else each for each in arguments)
