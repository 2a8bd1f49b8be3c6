"""A program that is stopped and stepped: at every decision, or where a breakpoint is met."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from enum import Enum, auto
from threading import Thread

from rich.text import Text

from ntp_dsl.cli.display import messages
from ntp_dsl.cli.watching import Watched, watched
from ntp_dsl.common.files import episode_files
from ntp_dsl.common.text import printable
from ntp_dsl.evaluation.episodes import Evaluator
from ntp_dsl.execution.supervision import Injection, Injections, Supervisor
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.protocol import Choice, Frame
from ntp_dsl.traces.decision import Decision
from ntp_dsl.traces.explanation import reasons
from ntp_dsl.traces.phrases import format_invocation

HELP = "Enter: to the next decision; o: over the call; c: to the next breakpoint; w: why; q: quit"
PLACE = re.compile(r"(?:[\w.-]+\.ntp:)?\d+")


@dataclass(frozen=True)
class Breakpoint:
    """Where to stop: at a call of a program or api, at a line, or when a fact is seen to come about."""

    text: str  # plain, see `_plain`
    is_fact: bool

    @classmethod
    def parse(cls, text: str, registry: Registry) -> Breakpoint:
        """Return what a text means. Raises `NtpError` for what the library does not have."""
        plain = _plain(text)
        name = plain.removeprefix("not ").partition("(")[0]
        if PLACE.fullmatch(plain) or name in registry.programs or name in registry.apis:
            return cls(plain, False)
        if name in registry.predicates and "(" in plain:
            return cls(plain, True)
        known = [*registry.programs, *registry.apis, *registry.predicates]
        hint = f"; did you mean '{near}'?" if (near := nearest(name, known)) else ""
        raise NtpError(
            "--break: expected a program, an api, a line such as 12 or "
            f"{registry.name}.ntp:12, or a fact such as holding(block_3), found '{text}'{hint}"
        )

    def is_met(self, choice: Choice, facts: frozenset[str]) -> bool:
        """Return whether to stop before a choice; `facts` are those that were not seen to hold before."""
        if self.is_fact:
            return self.text in facts
        if choice.callee is None:
            return False
        whole = _plain(format_invocation(choice.callee, choice.arguments))
        place = choice.decision.source
        return self.text in (choice.callee, whole, place, place.rpartition(":")[2])


class _Mode(Enum):
    STEP = auto()  # stop at the next decision
    OVER = auto()  # stop at the next decision of this program, or of a caller
    ON = auto()  # stop at a breakpoint


class Stepper(Injections):
    """Stops before decisions, shows them, and waits for a line that says how to go on.

    Args:
        read: returns the next line; an empty string where there are no more, on which it goes on to the end.
        shown: is told what is waited for, and an empty text when it goes on.
    """

    def __init__(
        self,
        step: bool,
        breakpoints: Sequence[Breakpoint],
        injections: Sequence[Injection],
        read: Callable[[], str],
        shown: Callable[[str], None],
    ) -> None:
        super().__init__(injections)
        self._breakpoints, self._read, self._shown = breakpoints, read, shown
        self._mode = _Mode.STEP if step else _Mode.ON
        self._depth = 0  # of the program over whose call it goes
        self._seen: set[str] = set()  # facts, as they were seen last; those that did not hold with `not`

    def before(self, depth: int, frame: Frame, choice: Choice) -> None:
        """Show a decision and wait, where it is to be stopped at."""
        now = {*_seen(choice.decision)}
        new = frozenset(now - self._seen)
        met = next((each for each in self._breakpoints if each.is_met(choice, new)), None)
        self._seen = {fact for fact in self._seen if _negated(fact) not in now} | now
        stops = self._mode is _Mode.STEP or (self._mode is _Mode.OVER and depth <= self._depth)
        if met is not None or stops:
            self._wait(depth, frame, choice, met)

    def _wait(self, depth: int, frame: Frame, choice: Choice, met: Breakpoint | None) -> None:
        text = _described(frame, choice)
        if met is not None:
            messages.print(Text(f"breakpoint {met.text}", style="magenta"))
        messages.print(Text(text, style="bold"))
        self._shown(text)
        while True:
            messages.print(Text("step> ", style="cyan"), end="")
            line = self._read()
            word = line.strip()
            if word in ("w", "why"):
                for sentence in reasons(choice.decision):
                    messages.print(printable(sentence))
                continue
            if word in ("q", "quit"):
                raise KeyboardInterrupt
            modes = {"": _Mode.STEP, "s": _Mode.STEP, "o": _Mode.OVER, "c": _Mode.ON}
            if not line or word in modes:
                self._mode = modes[word] if line else _Mode.ON
                self._depth = depth
                self._shown("")
                return
            messages.print(HELP)


@contextmanager
def supervised(
    evaluator: Evaluator, number: int, step: bool, stop_at: Sequence[str], inject: Sequence[str], watch: bool
) -> Iterator[Supervisor | None]:
    """Give the supervisor that the options of a command ask for, and say which injections fitted no call."""
    registry, traces = evaluator.registry, evaluator.plan.traces
    breakpoints = [Breakpoint.parse(text, registry) for text in stop_at]
    injections = [Injection.parse(text, registry) for text in inject]
    stops = step or bool(breakpoints)
    with ExitStack() as stack:
        page: Watched | None = None
        if watch:
            assert traces is not None
            page = stack.enter_context(watched(episode_files(traces, number)[0]))
            if stops:
                Thread(target=page.listen, daemon=True).start()
        if not stops and not injections:
            yield None
            return
        read = page.read_line if page is not None else sys.stdin.readline
        stepper = Stepper(
            step, breakpoints, injections, read, page.wait_for if page is not None else _unshown
        )
        yield stepper
        for each in stepper.waiting:
            messages.print(f"no primitive was {each.call}: nothing was forced on it", style="yellow")


def _unshown(text: str) -> None:
    """Show it nowhere but at the terminal."""


def _seen(decision: Decision) -> Iterator[str]:
    """Yield the facts that a decision saw, plain; those that did not hold with `not`."""
    for each in decision.facts:
        yield _plain(each.fact) if each.probability > 0.5 else _negated(_plain(each.fact))


def _plain(text: str) -> str:
    """Return a fact or a call without spaces, but for the one after a `not`."""
    negation = "not " if text.strip().startswith("not ") else ""
    return negation + text.strip().removeprefix("not ").replace(" ", "")


def _negated(fact: str) -> str:
    return fact.removeprefix("not ") if fact.startswith("not ") else f"not {fact}"


def _described(frame: Frame, choice: Choice) -> str:
    """Return a decision in a line: who does what, by which line, and how surely."""
    who = format_invocation(frame.program, frame.arguments)
    what = (
        "returns" if choice.callee is None else f"calls {format_invocation(choice.callee, choice.arguments)}"
    )
    source = f"  {choice.decision.source}" if choice.decision.source else ""
    chance = choice.decision.probability
    return printable(f"{who} {what}{source}{f'  {chance:.0%}' if chance is not None else ''}")
