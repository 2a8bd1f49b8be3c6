"""The strict success test, and the attribution of failures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from ntp_dsl.evaluation.authors_test import authors_success
from ntp_dsl.evaluation.rehearsal import rehearsed
from ntp_dsl.execution.interpreter import Run
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax import nodes
from ntp_dsl.semantics.facts import Fact, Literal, bind
from ntp_dsl.semantics.geometry import Vector
from ntp_dsl.semantics.observation import Argument, Observation
from ntp_dsl.semantics.predicates import JUDGED, held, inside
from ntp_dsl.semantics.shortfalls import why_not
from ntp_dsl.semantics.state import State
from ntp_dsl.tasks.instances import Instance
from ntp_dsl.traces.failure_attribution import ATTRIBUTION_OF_OUTCOME
from ntp_dsl.traces.schema import Attribution, CallOutcome
from ntp_dsl.worlds.protocol import Outcome, Scene, World
from ntp_dsl.worlds.scenes import movable

STILL_FOR = 2.0  # [s] that the result must be stable
STILL = 0.001  # [m] that an object may move in that time
CONTACT_PREDICATES = ("on", "in")  # for which the world must also report contact
UNMOVED = 0.01  # [m] that an object that the goal does not name may have moved


class ShortfallKind(Enum):
    """How a result fails."""

    NOT_ACHIEVED = auto()
    NO_CONTACT = auto()
    IN_HAND = auto()
    KNOCKED_ASIDE = auto()  # by the arm in passing
    MOVED = auto()  # deliberately, without need
    NOT_STILL = auto()


@dataclass(frozen=True)
class Shortfall:
    """The first condition that a result does not meet."""

    kind: ShortfallKind
    message: str


@dataclass(frozen=True)
class Verdict:
    """The judgement of an episode."""

    success: bool
    success_authors: bool  # by the test of the paper's authors
    attributed_to: Attribution | None = None  # of a failure
    reason: str = ""


def judge(registry: Registry, world: World, instance: Instance, scene: Scene, run: Run) -> Verdict:
    """Judge the state of the world twice, two seconds apart."""
    before = world.truth()
    first = _shortfall(registry, world, instance, scene, run)
    world.settle(STILL_FOR)
    after = world.truth()
    second = _shortfall(registry, world, instance, scene, run) or _moved(before, after)
    authors = authors_success(after, instance.literals(registry, after), instance.goal)
    if second is None:
        return Verdict(True, True if authors is None else authors)
    attribution = _attribution(run, first)
    reason = second.message
    if not run.done:
        last = run.last_message if attribution is not Attribution.DECISION else ""
        reason = f"{reason}; {run}{last}"
    return Verdict(False, bool(authors), attribution, reason)


def _shortfall(
    registry: Registry, world: World, instance: Instance, scene: Scene, run: Run
) -> Shortfall | None:
    now = world.truth()
    state = State(registry, now, JUDGED)
    facts = instance.literals(registry, now)
    for literal in facts:
        if not state.holds(literal):
            return Shortfall(ShortfallKind.NOT_ACHIEVED, why_not(literal, state))
    literals = [part for fact in facts for part in _parts(state, fact)]
    for literal in literals:
        if literal.positive and registry.predicates[literal.predicate].provider in CONTACT_PREDICATES:
            item, support = map(str, literal.arguments)
            if not world.supported(item, support):
                return Shortfall(ShortfallKind.NO_CONTACT, f"{item} does not touch {support}")
    in_hand = held(now)
    if in_hand is not None:
        return Shortfall(ShortfallKind.IN_HAND, f"{in_hand} is in the hand")
    named = {argument for literal in literals for argument in literal.arguments}
    named |= {value for row in instance.goal for _, value in row.fields}
    for obj in movable(instance.objects):
        if obj.name in named or obj.name in world.disturbed:
            continue
        if any(obj.name in _above(scene, name) for name in named):
            continue  # it may have had to make room
        if _distance(now.positions[obj.name], scene.positions[obj.name]) > UNMOVED:
            if obj.name not in run.handled:
                return Shortfall(ShortfallKind.KNOCKED_ASIDE, f"{obj.name} was knocked aside")
            if obj.name not in _moved_by_expert(registry, instance, scene):
                return Shortfall(ShortfallKind.MOVED, f"{obj.name} was moved")
    return None


def _parts(state: State, fact: Fact) -> Iterator[Literal]:
    """Yield the literals that make a fact true: the parts of a composed one, the true options of an `or`,
    and those of the objects for which one of any object is true.
    """
    if isinstance(fact, Literal):
        declared = state.registry.predicates[fact.predicate]
        ways = state.ways(declared, fact.arguments)
        if ways is not None:
            of_each = [Literal(fact.predicate, way) for way in ways]
            for witness in filter(state.holds, of_each if fact.positive else ()):
                yield from _parts(state, witness)
            return
        if declared.body is None:
            yield fact
            return
        scope = bind(declared, fact.arguments)
        body, positive = declared.body, fact.positive
    else:
        scope, positive = fact.scope, True
        if not isinstance(fact.expression, nodes.Or):
            return
        true_options = [value for value in fact.expression.values if state.true(value, scope)]
        for each in (found for value in true_options for found in state.literals(value, scope)):
            yield from _parts(state, each)
        return
    for each in state.literals(body, scope, positive):
        yield from _parts(state, each)


def _above(scene: Scene, support: Argument) -> set[str]:
    """Return the objects above another at the start, at any height."""
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
    """Return what the expert grasps from the same start: by the library, those objects were in the way."""
    grasped: set[Argument] = set()
    rehearsed(registry, instance, scene, lambda seen: grasped.update({seen.held} if seen.held else ()))
    return grasped


def _moved(before: Observation, after: Observation) -> Shortfall | None:
    """Return an object that moves. A heap in a bin or bowl may settle; the goal tests that it is inside."""
    for name, position in after.positions.items():
        is_contained = any(inside(after, name, obj.name) for obj in after.objects)
        if _distance(position, before.positions[name]) > STILL and not is_contained:
            return Shortfall(ShortfallKind.NOT_STILL, f"{name} is not still")
    return None


def _attribution(run: Run, first: Shortfall | None) -> Attribution:
    """Return physics if the result was reached but fell, the cause of repeated failures, or the decision."""
    if run.done and (first is None or first.kind is ShortfallKind.KNOCKED_ASIDE):
        return Attribution.PHYSICS
    return Attribution.DECISION if run.done else attribution_of_failures(run)


def attribution_of_failures(run: Run) -> Attribution:
    """Return what most of the last failures of an unfinished run are attributed to; else the decision."""
    found = map(attribution_of_failure, run.failures[-5:])
    kinds = Counter(kind for kind in found if kind is not None)
    return kinds.most_common(1)[0][0] if len(run.failures) >= 3 and kinds else Attribution.DECISION


def attribution_of_failure(failure: Outcome) -> Attribution | None:
    """Return what the failure of a primitive is attributed to; None where the call was refused."""
    return (
        Attribution.DISTURBANCE
        if failure.disturbances
        else ATTRIBUTION_OF_OUTCOME.get(CallOutcome.of(failure))
    )


def _distance(a: Vector, b: Vector) -> float:
    return float(np.linalg.norm(np.subtract(a, b)))
