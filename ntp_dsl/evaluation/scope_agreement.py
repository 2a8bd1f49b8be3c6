"""How far the parts of a demonstration that a policy reads are those that the expert's own calls took."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ntp_dsl.execution.interpreter import Watcher
from ntp_dsl.policies.scripted import like_calls
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.comparison.comparison_rules import overlap
from ntp_dsl.traces.schema import DemonstratedCall


@dataclass(frozen=True)
class ScopeAgreement:
    """The scopes of one callee's calls, beside the expert's of the same calls."""

    calls: int  # that the expert made as well, each time that it is made
    overlap: float  # mean intersection over union of the frames


class ScopeWatcher:
    """Follows a run, and holds the scope of each call against that of the demonstration's own call.

    The counterpart of a call is the last one below its caller's counterpart that has the same callee and
    arguments, and succeeded. The root is left out: its scope is all of the demonstration.
    """

    def __init__(self, demonstrated: DemonstratedCall, then: Watcher | None = None) -> None:
        self._path: list[DemonstratedCall | None] = [demonstrated]
        self._then = then
        self.overlaps: dict[str, list[float]] = {}

    def __call__(
        self, event: str, depth: int, name: str, arguments: tuple[Argument, ...], detail: Any
    ) -> None:
        if event == "call" and depth > 0:
            del self._path[depth:]
            found = _counterpart(self._path[-1], name, arguments)
            self._path.append(found)
            if found is not None:
                self.overlaps.setdefault(name, []).append(overlap(detail, found.scope))
        if self._then is not None:
            self._then(event, depth, name, arguments, detail)


def _counterpart(
    caller: DemonstratedCall | None, callee: str, arguments: tuple[Argument, ...]
) -> DemonstratedCall | None:
    """Return the expert's call. A learned program hands no lists on, so they are not compared."""
    calls = like_calls(caller, callee, arguments) if caller is not None else []
    return next((each for each in reversed(calls) if each.done), None)


def agreement(overlaps: Sequence[Mapping[str, Sequence[float]]]) -> dict[str, ScopeAgreement]:
    """Return the agreement of each callee over several episodes, in the order of their names."""
    together: dict[str, list[float]] = {}
    for each in overlaps:
        for name, values in each.items():
            together.setdefault(name, []).extend(values)
    return {
        name: ScopeAgreement(len(values), round(sum(values) / len(values), 4))
        for name, values in sorted(together.items())
    }
