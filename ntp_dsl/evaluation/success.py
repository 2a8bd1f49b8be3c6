"""The strict success test, and what every failure is attributed to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from ntp_dsl.evaluation.authors_test import authors_success
from ntp_dsl.execution.interpreter import Interpreter, Limits, Run
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.semantics.predicates import JUDGED, held, inside
from ntp_dsl.semantics.state import Bindings, Fact, Literal, State
from ntp_dsl.tasks.instances import Instance, enough_primitives
from ntp_dsl.traces.failure_attribution import ATTRIBUTION_OF_OUTCOME
from ntp_dsl.traces.schema import Attribution, CallOutcome
from ntp_dsl.worlds.catalogue import make_world
from ntp_dsl.worlds.protocol import Scene, World
from ntp_dsl.worlds.scenes import movable

STILL_FOR = 2.0  # [s] that the result must stand
STILL = 0.001  # [m] that anything may creep in that time
RESTING = ("on", "in")  # of which the world is asked for contacts as well
STAYED = 0.01  # [m] that an object the goal does not name may have moved


class Kind(Enum):
    """How a result falls short."""

    NOT_ACHIEVED = auto()
    NO_CONTACT = auto()
    IN_HAND = auto()
    KNOCKED_ASIDE = auto()  # by the arm, on its way
    MOVED = auto()  # on purpose, for nothing
    NOT_STILL = auto()


@dataclass(frozen=True)
class Shortfall:
    """The first object that is not as it should be."""

    kind: Kind
    message: str


@dataclass(frozen=True)
class Verdict:
    """What is judged of an episode."""

    success: bool
    success_authors: bool  # by the test of the paper's authors
    attributed_to: Attribution | None = None  # of a failure
    reason: str = ""


def judge(registry: Registry, world: World, instance: Instance, scene: Scene, run: Run) -> Verdict:
    """Judge what is there, by two looks that are two seconds apart."""
    before = world.truth()
    first = _shortfall(registry, world, instance, scene, run)
    world.settle(STILL_FOR)
    after = world.truth()
    second = _shortfall(registry, world, instance, scene, run) or _crept(before, after)
    authors = authors_success(after, instance.literals(registry, after), instance.goal)
    if second is None:
        return Verdict(True, True if authors is None else authors)
    attribution = _attribution(run, first)
    reason = second.message
    if not run.done:
        said = _last_message(run) if attribution is not Attribution.DECISION else ""
        reason = f"{reason}; {run.ending}: {run.reason}{said}"
    return Verdict(False, bool(authors), attribution, reason)


def _last_message(run: Run) -> str:
    """Return what the world said of the primitive that failed last, where it says more than a word."""
    said = [str(failure.evidence["message"]) for failure in run.failures if "message" in failure.evidence]
    return f"; last: {said[-1]}" if said else ""


def _shortfall(
    registry: Registry, world: World, instance: Instance, scene: Scene, run: Run
) -> Shortfall | None:
    now = world.truth()
    state = State(registry, now, JUDGED)
    for literal in instance.literals(registry, now):
        if not state.holds(literal):
            return Shortfall(Kind.NOT_ACHIEVED, f"{literal} does not hold")
    literals = [part for fact in instance.literals(registry, now) for part in _parts(state, fact)]
    for literal in literals:
        if literal.positive and _built_in(registry, literal.predicate) in RESTING:
            item, support = map(str, literal.arguments)
            if not world.supported(item, support):
                return Shortfall(Kind.NO_CONTACT, f"{item} does not touch {support}")
    in_hand = held(now)
    if in_hand is not None:
        return Shortfall(Kind.IN_HAND, f"{in_hand} is in the hand")
    named = {argument for literal in literals for argument in literal.arguments}
    named |= {value for row in instance.goal for _, value in row.fields}
    for obj in movable(instance.objects):
        if obj.name in named or obj.name in world.disturbed:
            continue
        if any(obj.name in _above(scene, name) for name in named):
            continue  # it had to make room
        if _distance(now.positions[obj.name], scene.positions[obj.name]) > STAYED:
            if obj.name not in run.handled:
                return Shortfall(Kind.KNOCKED_ASIDE, f"{obj.name} was knocked aside")
            if obj.name not in _moved_by_expert(registry, instance, scene):
                return Shortfall(Kind.MOVED, f"{obj.name} was moved")
    return None


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
    """What stood over an object at the start, at whatever height."""
    if not isinstance(support, str) or support not in scene.positions:
        return set()
    x, y, z = scene.positions[support]
    below = scene.by_name[support]
    if below.roomy:
        return set()
    return {
        obj.name
        for obj in movable(scene.objects)
        if scene.positions[obj.name][2] > z
        and abs(scene.positions[obj.name][0] - x) < (below.size[0] + obj.size[0]) / 2
        and abs(scene.positions[obj.name][1] - y) < (below.size[1] + obj.size[1]) / 2
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


def _crept(before: Observation, after: Observation) -> Shortfall | None:
    """Return what moves. A heap in a bin or bowl may settle: that it stays inside is asked anyway."""
    for name, position in after.positions.items():
        lies_in_one = any(inside(after, name, obj.name) for obj in after.objects)
        if _distance(position, before.positions[name]) > STILL and not lies_in_one:
            return Shortfall(Kind.NOT_STILL, f"{name} is not still")
    return None


def _attribution(run: Run, first: Shortfall | None) -> Attribution:
    """Physics where all was well and then fell, or was knocked; the arm where it gave up; else decisions."""
    if run.done and (first is None or first.kind is Kind.KNOCKED_ASIDE):
        return Attribution.PHYSICS
    if run.done:
        return Attribution.DECISION
    found = (ATTRIBUTION_OF_OUTCOME.get(CallOutcome.of(failure)) for failure in run.failures[-5:])
    kinds = Counter(kind for kind in found if kind is not None)
    return kinds.most_common(1)[0][0] if len(run.failures) >= 3 and kinds else Attribution.DECISION


def _distance(a: Vector, b: Vector) -> float:
    return float(np.linalg.norm(np.subtract(a, b)))
