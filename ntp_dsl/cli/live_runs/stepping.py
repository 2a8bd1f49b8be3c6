"""A program that is stopped and stepped: at every decision, or where a breakpoint is met."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from enum import Enum, auto
from typing import TYPE_CHECKING

from rich.text import Text

from ntp_dsl.cli.display import messages
from ntp_dsl.cli.terminal import read_line
from ntp_dsl.common.files import episode_files
from ntp_dsl.common.text import counted, printable
from ntp_dsl.evaluation.episodes import Evaluator
from ntp_dsl.execution.supervision import CallPattern, Injections, Supervisor, check_names
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Choice, Frame
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.decision import Decision
from ntp_dsl.traces.explanation import reasons
from ntp_dsl.traces.phrases import format_invocation
from ntp_dsl.worlds.protocol import Outcome, World

if TYPE_CHECKING:
    from ntp_dsl.cli.live_runs.live_page import LiveRun

HELP = "Enter: to the next decision; o: over the call; c: to the next breakpoint; w: why; q: quit"
PLACE = re.compile(r"(?:([\w.-]+\.ntp):)?(\d{1,6})")
FACT = re.compile(r"(not )?(\w+)\((.*)\)")


@dataclass(frozen=True)
class Breakpoint:
    """Where to stop: at a call, at a line, or when a fact is seen to come about; one of the three."""

    text: str
    call: CallPattern | None = None
    place: str = ""  # `file:line`, or a line of any file
    fact: str = ""  # plain, see `_plain`

    @classmethod
    def parse(cls, text: str, registry: Registry, objects: Sequence[str]) -> Breakpoint:
        """Return what a text means. Raises `NtpError` for what the library, or the scene, does not have.

        Args:
            objects: the names of those in the scene.
        """
        given = " ".join(text.split())
        if (line := PLACE.fullmatch(given)) and _has_line(registry, line[1], int(line[2])):
            return cls(given, place=given)
        if call := CallPattern.parse(given, {**registry.programs, **registry.apis}):
            check_names("--break", given, call.arguments or (), registry, objects)
            return cls(given, call=call)
        if (fact := FACT.fullmatch(given)) and fact[2] in registry.predicates:
            named = [each.strip() for each in fact[3].split(",") if each.strip()]
            parameters = [each.name for each in registry.predicates[fact[2]].parameters]
            if len(named) != len(parameters):
                takes = f"{fact[2]} takes ({', '.join(parameters)})"
                raise NtpError(f"--break: '{given}': {takes}, found {counted(len(named), 'argument')}")
            check_names("--break", given, named, registry, objects)
            return cls(given, fact=_plain(given))
        known = [*registry.programs, *registry.apis, *registry.predicates]
        hint = f"; did you mean '{near}'?" if (near := nearest(given.partition("(")[0], known)) else ""
        raise NtpError(
            "--break: expected a program, an api, a line such as 12 or "
            f"{registry.name}.ntp:12, or a fact such as holding(block_3), found '{text}'{hint}"
        )

    def is_met(self, choice: Choice, new: set[str]) -> bool:
        """Return whether to stop before a choice; `new` are the facts that were not seen to hold before."""
        if self.fact:
            return self.fact in new
        if choice.callee is None:
            return False
        if self.call is not None:
            return self.call.matches(choice.callee, choice.arguments)
        return self.place in (choice.decision.source, choice.decision.source.rpartition(":")[2])


def _has_line(registry: Registry, file: str | None, line: int) -> bool:
    """Return whether a call is made at a line."""
    spans = [each.span for row in registry.programs.values() for each in row.statements()]
    return any(span.line == line and span.path and file in (None, span.path.name) for span in spans)


class _Mode(Enum):
    STEP = auto()  # stop at the next decision
    OVER = auto()  # stop at the next decision of this program, or of a caller
    ON = auto()  # stop at a breakpoint
    FREE = auto()  # stop nowhere: there is nobody who could say how to go on


class Stepper:
    """Stops before decisions, shows them, and waits for a line that says how to go on.

    Args:
        read: returns the next line; an empty string where there are no more, on which it goes on to the end.
        announce: is told what is waited for, and an empty text when it goes on.
    """

    def __init__(
        self,
        step: bool,
        breakpoints: Sequence[Breakpoint],
        injections: Injections,
        read: Callable[[], str],
        announce: Callable[[str], None],
    ) -> None:
        self._injections, self._read, self._announce = injections, read, announce
        self._breakpoints = breakpoints
        self.unmet = [*breakpoints]
        self._mode = _Mode.STEP if step else _Mode.ON
        self._depth = 0  # of the program over whose call it goes
        self._seen: set[str] = set()  # facts, as they were seen last; those that did not hold with `not`

    def outcome(self, callee: str, arguments: tuple[Argument, ...]) -> Outcome | None:
        """Return what is forced on a primitive, or None."""
        return self._injections.outcome(callee, arguments)

    def world(self, frame: Frame, world: World) -> World:
        """Return the world with the facts that are forced on what a program sees."""
        return self._injections.world(frame, world)

    def before(self, depth: int, frame: Frame, choice: Choice) -> None:
        """Show a decision and wait, where it is to be stopped at."""
        now = {*_seen(choice.decision)}
        new = now - self._seen
        met = [each for each in self._breakpoints if each.is_met(choice, new)]
        self.unmet = [each for each in self.unmet if each not in met]
        self._seen = {fact for fact in self._seen if _negated(fact) not in now} | now
        stops = self._mode is _Mode.STEP or (self._mode is _Mode.OVER and depth <= self._depth)
        if (met and self._mode is not _Mode.FREE) or stops:
            self._wait(depth, frame, choice, met)

    def _wait(self, depth: int, frame: Frame, choice: Choice, met: Sequence[Breakpoint]) -> None:
        text = _described(frame, choice)
        for each in met:
            messages.print(Text(f"breakpoint {each.text}", style="magenta"))
        messages.print(Text(text, style="bold"))
        self._announce(text)
        self._mode = self._answer(choice.decision)
        self._depth = depth
        self._announce("")

    def _answer(self, decision: Decision) -> _Mode:
        """Return how to go on. Raises `KeyboardInterrupt` where that is not at all."""
        modes = {"": _Mode.STEP, "s": _Mode.STEP, "o": _Mode.OVER, "c": _Mode.ON}
        while True:
            messages.print(Text("step> ", style="cyan"), end="")
            line = self._read()
            word = line.strip()
            if not line:
                return _Mode.FREE
            if word in modes:
                return modes[word]
            if word in ("q", "quit"):
                raise KeyboardInterrupt
            if word in ("w", "why"):
                for sentence in reasons(decision):
                    messages.print(printable(sentence))
            else:
                messages.print(HELP)


@contextmanager
def supervised(
    evaluator: Evaluator,
    number: int,
    step: bool,
    stop_at: Sequence[str],
    inject: Sequence[str],
    watch: bool,
    viewer: str | None,
) -> Iterator[Supervisor | None]:
    """Give the supervisor that a command's options ask for; at the end say which of them fitted nothing."""
    registry, traces = evaluator.registry, evaluator.plan.traces
    is_told = bool(stop_at or inject)
    objects = [each.name for each in evaluator.instance(number).objects] if is_told else []
    breakpoints = [Breakpoint.parse(text, registry, objects) for text in stop_at]
    injections = Injections(inject, registry, objects)
    with ExitStack() as stack:
        page: LiveRun | None = None
        if watch:
            from ntp_dsl.cli.live_runs.live_page import live  # and with it a server

            assert traces is not None
            page = stack.enter_context(live(episode_files(traces, number)[0]))
            page.begin()
        if viewer is not None:
            from ntp_dsl.cli.live_runs.live_viewer import streamed

            assert traces is not None
            stack.enter_context(streamed(episode_files(traces, number)[0], viewer))
        if not step and not breakpoints and not injections:
            yield None
            return
        read = page.read_line if page is not None else read_line
        announce = page.announce if page is not None else _to_nobody
        stepper = Stepper(step, breakpoints, injections, read, announce)
        try:
            yield stepper
        finally:
            for breakpoint in stepper.unmet:
                messages.print(f"breakpoint {breakpoint.text} was never met", style="yellow")
            for injection in injections.waiting:
                messages.print(f"no primitive was {injection.call}: nothing was forced on it", style="yellow")
            for fact in injections.unseen:
                text = f"no decision was made by {fact.node}: nothing was forced on it"
                messages.print(text, style="yellow")
            for fact in injections.unread:
                text = f"{fact.text} changed nothing: no decision asked whether it holds"
                messages.print(text, style="yellow")


def _to_nobody(text: str) -> None:
    """Leave it at what the terminal shows."""


def _seen(decision: Decision) -> Iterator[str]:
    """Yield the facts that a decision saw, plain; those that did not hold with `not`."""
    for each in decision.facts:
        yield _plain(each.fact) if each.probability > 0.5 else _negated(_plain(each.fact))


def _plain(fact: str) -> str:
    """Return a fact without spaces, but for the one after a `not`."""
    negation = "not " if fact.startswith("not ") else ""
    return negation + fact.removeprefix("not ").replace(" ", "")


def _negated(fact: str) -> str:
    return fact.removeprefix("not ") if fact.startswith("not ") else f"not {fact}"


def _described(frame: Frame, choice: Choice) -> str:
    """Return a decision in a line: who does what, by which line, and how surely."""
    who = format_invocation(frame.program, frame.arguments)
    call = "" if choice.callee is None else format_invocation(choice.callee, choice.arguments)
    source = f"  {choice.decision.source}" if choice.decision.source else ""
    chance = choice.decision.probability
    sure = f"  {chance:.0%}" if chance is not None else ""
    return printable(f"{who} {f'calls {call}' if call else 'returns'}{source}{sure}")
