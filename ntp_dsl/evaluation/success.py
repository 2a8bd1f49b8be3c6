"""Two success tests, and for every failure who is to blame."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from math import hypot

import numpy as np

from ntp_dsl.execution.interpreter import Interpreter, Limits, Run
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import Argument, Observation, Vector
from ntp_dsl.semantics.predicates import JUDGED, held, inside
from ntp_dsl.semantics.state import Bindings, Fact, Literal, State
from ntp_dsl.tasks.goal_samplers import Goal
from ntp_dsl.tasks.instances import Instance, enough_primitives
from ntp_dsl.traces.failure_attribution import OF_FAILURE
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import Scene, World
from ntp_dsl.worlds.scenes import movable

STILL_FOR = 2.0  # [s] that the result must stand
STILL = 0.001  # [m] that anything may creep in that time
RESTING = ("on", "in")  # of which the world is asked for contacts as well
KNOCKED = "knocked aside"
STAYED = 0.01  # [m] that a thing the goal does not name may have moved


@dataclass(frozen=True)
class Verdict:
    blame: str
    reason: str
    authors: bool


def judge(registry: Registry, world: World, instance: Instance, scene: Scene, run: Run) -> Verdict:
    """The strict test, and the paper's authors' own; looks twice, two seconds apart."""
    before = world.truth()
    wrong_before = _wrong(registry, world, instance, scene, run)
    world.settle(STILL_FOR)
    after = world.truth()
    wrong = _wrong(registry, world, instance, scene, run) or _crept(before, after)
    facts = instance.literals(registry, after)
    stacked = all(isinstance(fact, Literal) and fact.predicate == "on" for fact in facts)
    placed = all({"item", "support"} <= {name for name, _ in row.fields} for row in instance.goal)
    authors = authors_success(after, instance.goal) if placed and stacked else not wrong
    if not wrong:
        return Verdict("", "", authors)
    blame = _blame(run, wrong_before)
    if not run.done:
        wrong = f"{wrong}; {run.reason}{_last_words(run) if blame != 'decision' else ''}"
    return Verdict(blame, wrong, authors)


def _last_words(run: Run) -> str:
    """What the world said of the primitive that failed last, where it says more than a word."""
    said = [str(failure.evidence["message"]) for failure in run.failures if "message" in failure.evidence]
    return f"; last: {said[-1]}" if said else ""


def _wrong(registry: Registry, world: World, instance: Instance, scene: Scene, run: Run) -> str:
    """The first thing that is not as it should be, or nothing."""
    now = world.truth()
    state = State(registry, now, JUDGED)
    for literal in instance.literals(registry, now):
        if not state.holds(literal):
            return f"{literal} does not hold"
    literals = [part for fact in instance.literals(registry, now) for part in _parts(state, fact)]
    for literal in literals:
        if literal.positive and _built_in(registry, literal.predicate) in RESTING:
            item, support = map(str, literal.arguments)
            if not world.supported(item, support):
                return f"{item} does not touch {support}"
    in_hand = held(now)
    if in_hand is not None:
        return f"{in_hand} is in the hand"
    named = {argument for literal in literals for argument in literal.arguments}
    named |= {value for row in instance.goal for _, value in row.fields}
    for thing in movable(instance.things):
        if thing.name in named or thing.name in world.disturbed:
            continue
        if any(thing.name in _above(scene, name) for name in named):
            continue  # it had to make room
        if _distance(now.positions[thing.name], scene.positions[thing.name]) > STAYED:
            if thing.name not in run.handled:
                return f"{thing.name} was {KNOCKED}"
            if thing.name not in _moved_by_expert(registry, instance, scene):
                return f"{thing.name} was moved"
    return ""


def _parts(state: State, fact: Fact) -> Iterator[Literal]:
    """The literals that make a fact true which holds: of a composed one its parts, of a choice those met."""
    if isinstance(fact, Literal):
        declared = state.registry.predicates[fact.predicate]
        if declared.body is None:
            yield fact
            return
        names = (parameter.name for parameter in declared.parameters)
        scope: Bindings = dict(zip(names, fact.arguments, strict=True))
        body, positive = declared.body, fact.positive
    else:
        scope, positive = fact.scope, True
        if not isinstance(fact.expression, nodes.Or):
            return
        met = [value for value in fact.expression.values if state.true(value, scope)]
        for each in (found for value in met for found in state.literals(value, scope)):
            yield from _parts(state, each)
        return
    for each in state.literals(body, scope, positive):
        yield from _parts(state, each)


def _built_in(registry: Registry, predicate: str) -> str:
    """The name under which the worlds know a predicate."""
    provider = registry.predicates[predicate].by
    return provider.id if provider else predicate


def _above(scene: Scene, support: Argument) -> set[str]:
    """What stood over a thing at the start, at whatever height."""
    if not isinstance(support, str) or support not in scene.positions:
        return set()
    x, y, z = scene.positions[support]
    below = scene.by_name[support]
    if below.roomy:
        return set()
    return {
        thing.name
        for thing in movable(scene.things)
        if scene.positions[thing.name][2] > z
        and abs(scene.positions[thing.name][0] - x) < (below.size[0] + thing.size[0]) / 2
        and abs(scene.positions[thing.name][1] - y) < (below.size[1] + thing.size[1]) / 2
    }


def _moved_by_expert(registry: Registry, instance: Instance, scene: Scene) -> set[Argument]:
    """What the expert takes into the hand from the same start: it was in the way, as the library sees it."""
    world = make_world("kinematic", registry, exact=True)
    world.reset(scene, 0)
    taken: set[Argument] = set()
    world.on_frame = lambda seen: taken.update({seen.held} if seen.held else ())
    limits = Limits(primitives=enough_primitives(instance))
    Interpreter(registry, ScriptedPolicy(Expert(registry)), world, limits=limits).run(
        instance.program, instance.arguments
    )
    return taken


def _crept(before: Observation, after: Observation) -> str:
    """What moves. A heap in a bin or bowl may settle: that what is in there stays in, is asked anyway."""
    for name, position in after.positions.items():
        lies_in_one = any(inside(after, name, thing.name) for thing in after.things)
        if _distance(position, before.positions[name]) > STILL and not lies_in_one:
            return f"{name} is not still"
    return ""


def _blame(run: Run, wrong_before: str) -> str:
    """Physics where all was well and then fell, or was knocked; the arm where it gave up; else decisions."""
    if run.done and (not wrong_before or wrong_before.endswith(KNOCKED)):
        return "physics"
    if run.done:
        return "decision"
    kinds = Counter(OF_FAILURE[f.failure] for f in run.failures[-5:] if f.failure in OF_FAILURE)
    return kinds.most_common(1)[0][0] if len(run.failures) >= 3 and kinds else "decision"


def authors_success(now: Observation, goal: Goal) -> bool:
    """The test of the paper's authors: within 0.05 m of each other seen from above, and higher."""
    for placement in goal:
        x, y, z = now.positions[str(placement["item"])]
        sx, sy, sz = now.positions[str(placement["support"])]
        if hypot(x - sx, y - sy) > 0.05 or z <= sz:
            return False
    return True


def _distance(a: Vector, b: Vector) -> float:
    return float(np.linalg.norm(np.subtract(a, b)))
