"""Nameless random sequences: each call needs what one before it does, and the last one is what is wanted."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ntp_dsl.core.pretraining.dispatch_data import Sample
from ntp_dsl.core.pretraining.nameless_programs import believed, decision, doubted, joined, nameless_library
from ntp_dsl.language.registry import Api, Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.policies.expert import Expert, NextCall

SHORTEST, LONGEST = 2, 12  # steps
TOOLS = 3  # at most: facts that one step brings about for those after it, and a later one ends
FOLLOWS, EARLIER, WITHIN = 0.85, 0.2, 0.7  # how often a step needs the one before, another one, a tool
WANTED, ENDED, LAST = 0.1, 0.8, 0.95  # how often a step's fact is wanted, the end of a tool, the last fact
KEPT, LENT = 0.5, 0.3  # how often a tool comes from where it is to go, and is out of use for a while
SILENT, RESULT = 0.2, "g"  # how often the last step brings about what no call promises, and that fact
GUARDED, STRAY, DOUBTFUL = 0.1, 0.05, 0.1


@dataclass(frozen=True)
class _Step:
    """A call: what it achieves, and what it requires; literals that begin with a minus are negated."""

    achieves: tuple[str, ...]
    requires: tuple[str, ...] = ()
    guard: str = ""


def sequence(rng: np.random.Generator) -> list[Sample]:
    """Return decisions on the way through a random sequence: what is right by the truth, told in doubt."""
    registry, initially = random_sequence(rng)
    start = {name: float((name in initially) != (rng.random() < STRAY)) for name in registry.predicates}
    found: list[Sample] = []
    for true in way(registry, start):
        strayed = {name: abs(value - float(rng.random() < STRAY)) for name, value in true.items()}
        probabilities, truth = doubted(strayed, DOUBTFUL, rng)
        sample = decision(registry, probabilities, truth)
        found += [sample] if sample is not None else []
    return found


def way(registry: Registry, true: dict[str, float]) -> Iterator[dict[str, float]]:
    """Yield the states that an expert comes through: at most as many as there are calls."""
    expert, last = Expert(registry), [*registry.apis][-1]
    for _ in registry.apis:
        yield true
        call = expert.decide("p", (), believed(registry, true))
        if not isinstance(call, NextCall):
            return
        true = _after(registry.apis[call.callee], true)
        if call.callee == last and RESULT in true:
            true[RESULT] = 1.0


def _after(api: Api, true: Mapping[str, float]) -> dict[str, float]:
    """Return the facts after a call."""
    parts = api.achieves.values if isinstance(api.achieves, nodes.And) else (api.achieves,)
    found = dict(true)
    for part in parts:
        if isinstance(part, nodes.Not) and isinstance(part.value, nodes.Atom):
            found[part.value.predicate] = 0.0
        elif isinstance(part, nodes.Atom):
            found[part.predicate] = 1.0
    return found


def random_sequence(rng: np.random.Generator) -> tuple[Registry, set[str]]:
    """Return a library of one program, `p`, whose calls follow from one another, and what holds at first."""
    steps = _plain_steps(int(rng.integers(SHORTEST, LONGEST + 1)), rng)
    wanted = [each.achieves[0] for each in steps[:-1] if rng.random() < WANTED]
    wanted += [steps[-1].achieves[0]] if rng.random() < LAST or not wanted else []
    if rng.random() < SILENT:
        wanted = [RESULT]
    initially: set[str] = set()
    for number in range(int(rng.integers(0, TOOLS + 1))):
        tool, home = f"t{number}", f"h{number}" if rng.random() < KEPT else ""
        initially |= {home} - {""}
        steps = _with_tool(tool, home, steps, rng)
        wanted += [home or f"-{tool}"] if rng.random() < ENDED else []
    named = {each.removeprefix("-") for step in steps for each in (*step.achieves, *step.requires)}
    names = sorted(named | initially | {each.removeprefix("-") for each in wanted})
    apis = {
        f"c{number}": Api(f"c{number}", (), _all(step.requires), _all(step.achieves), "")
        for number, step in enumerate(steps)
    }
    pairs = zip(apis, steps, strict=True)
    body = tuple(_statement(name, step.guard or _any_guard(names, rng)) for name, step in pairs)
    return nameless_library(names, apis, body, None, _all(wanted)), initially


def _plain_steps(count: int, rng: np.random.Generator) -> list[_Step]:
    found: list[_Step] = []
    for number in range(count):
        needed = {number - 1} if number and rng.random() < FOLLOWS else set()
        needed |= {int(rng.integers(number))} if number and rng.random() < EARLIER else set()
        found.append(_Step((f"s{number}",), tuple(f"s{each}" for each in sorted(needed))))
    return found


def _with_tool(tool: str, home: str, steps: Sequence[_Step], rng: np.random.Generator) -> list[_Step]:
    """Return the steps with two more: one fetches what some between them need, and one puts it away.

    Args:
        home: the fact that holds while it is not in use; empty where there is none.
    """
    first, last = sorted(int(each) for each in rng.integers(0, len(steps) + 1, size=2))
    between = [
        replace(each, requires=(*each.requires, tool)) if rng.random() < WITHIN else each
        for each in steps[first:last]
    ]
    if len(between) > 1 and rng.random() < LENT:
        lent, back = sorted(int(each) for each in rng.choice(len(between), size=2, replace=False))
        between[lent] = replace(between[lent], achieves=(*between[lent].achieves, f"-{tool}"))
        between[lent + 1 : back + 1] = [
            replace(each, requires=tuple(fact for fact in each.requires if fact != tool))
            for each in between[lent + 1 : back + 1]
        ]
        between[back] = replace(between[back], achieves=(*between[back].achieves, tool))
    before = steps[last - 1].achieves[:1] if last and rng.random() < 0.5 else ()
    fetched = _Step((tool, f"-{home}"), guard=home * bool(rng.random() < 0.5)) if home else _Step((tool,))
    returned = _Step((home, f"-{tool}") if home else (f"-{tool}",), (*before, *([tool] if home else [])))
    return [*steps[:first], fetched, *between, returned, *steps[last:]]


def _any_guard(names: Sequence[str], rng: np.random.Generator) -> str:
    return str(rng.choice(names)) if rng.random() < GUARDED else ""


def _statement(name: str, guard: str) -> nodes.Statement:
    call = nodes.Call(name)
    return nodes.When(_literal(guard), call) if guard else call


def _literal(text: str) -> nodes.Expression:
    atom = nodes.Atom(text.removeprefix("-"))
    return nodes.Not(atom) if text.startswith("-") else atom


def _all(texts: Sequence[str]) -> nodes.Expression | None:
    return joined([_literal(each) for each in texts])
