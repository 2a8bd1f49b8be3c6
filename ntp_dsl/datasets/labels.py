"""Sample queries from recorded episodes: every decision made, and programs that were not on the stack."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.queries import Answer, Query, Sample
from ntp_dsl.language.registry import Program
from ntp_dsl.policies.expert import Expert, Return
from ntp_dsl.policies.random_arguments import random_arguments
from ntp_dsl.policies.scripted import counterpart, shown_anywhere
from ntp_dsl.semantics.observation import Argument, Observation, without_lists
from ntp_dsl.semantics.state import State
from ntp_dsl.traces.schema import ROOT, Call, CallOutcome, DemonstratedCall
from ntp_dsl.traces.trace import Trace

DISTRACTOR = "distractor"
ASIDE = 0.2  # from all other objects, seen from above [m]
TABLE = ((0.15, 0.95), (-0.5, 0.5))  # where it may stand [m]
DRAWS = 20  # of its place


@dataclass(frozen=True)
class LabelConfig:
    """What a core is asked in training; part of a checkpoint's recipe."""

    off_stack: int = 2  # queries about programs off the stack, for each state
    off_stack_of_new: int = 8  # the same, for each state that no episode went through
    distractors: float = 0.5  # how often one more object is added to a state
    demonstrated: float = 0.5  # how often a query is about a call that the demonstration shows
    new_states: int = 3000  # in all,
    new_states_of_episode: int = 60  # and for an episode, at most


def labelled(
    config: LabelConfig,
    expert: Expert,
    demonstration: Demonstration,
    shown: DemonstratedCall,
    trace: Trace,
    new_states: Iterable[Observation],
    rng: np.random.Generator,
) -> Iterator[Sample]:
    """Yield the trace's decisions, and the expert's on programs drawn at random, for each of its states.

    Args:
        new_states: of any scenes, with whatever objects; nothing in the demonstration is about them.
    """
    yield from _on_stack(expert, demonstration, trace)
    for observation in trace.states:
        for _ in range(config.off_stack):
            yield _off_stack(config, expert, demonstration, shown, observation, rng)
    for observation in new_states:
        for _ in range(config.off_stack_of_new):
            sample = _off_stack(config, expert, demonstration, None, observation, rng)
            yield replace(sample, is_new=True)


def _on_stack(expert: Expert, demonstration: Demonstration, trace: Trace) -> Iterator[Sample]:
    calls = {call.id: call for call in trace.calls}
    for call in trace.calls:
        if call.parent != ROOT:
            query = _query(calls[call.parent], trace.states[call.state], demonstration)
            yield Sample(query, Answer(call.name, without_lists(call.arguments), call.scope))
    for call in trace.calls:
        if call.is_program and call.outcome is not None and call.outcome.is_return:
            assert call.end_state is not None
            state = trace.states[call.end_state]
            answer = Answer(None, done=call.outcome is CallOutcome.DONE)
            yield Sample(_query(call, state, demonstration), answer)


def _query(call: Call, state: Observation, demonstration: Demonstration) -> Query:
    return Query(call.name, without_lists(call.arguments), call.scope, state, demonstration)


def _off_stack(
    config: LabelConfig,
    expert: Expert,
    demonstration: Demonstration,
    shown: DemonstratedCall | None,
    observation: Observation,
    rng: np.random.Generator,
) -> Sample:
    program, arguments = random_call(expert, observation, shown, rng, config.demonstrated)
    if rng.random() < config.distractors:
        observation = with_distractor(observation, rng)
    node = shown_anywhere(shown, program.name, arguments) if shown else None
    scope = node.scope if node else None
    query = Query(program.name, without_lists(arguments), scope, observation, demonstration)
    decision = expert.decide(program.name, arguments, State(expert.registry, observation))
    if isinstance(decision, Return):
        return Sample(query, Answer(None, done=decision.done))
    child = counterpart(node, decision.callee, decision.arguments)
    answer = Answer(decision.callee, without_lists(decision.arguments), child.scope if child else None)
    return Sample(query, answer)


def random_call(
    expert: Expert,
    observation: Observation,
    shown: DemonstratedCall | None,
    rng: np.random.Generator,
    demonstrated: float = LabelConfig.demonstrated,
) -> tuple[Program, tuple[Argument, ...]]:
    """Return a program without lists on random objects, or, so often, a demonstrated call."""
    programs = [p for p in expert.registry.programs.values() if not p.takes_list]
    program = programs[int(rng.integers(len(programs)))]
    if shown is not None and rng.random() < demonstrated:
        calls = [call for call in shown.walk() if call.name == program.name]
        if calls:
            return program, calls[int(rng.integers(len(calls)))].arguments
    state = State(expert.registry, observation)
    arguments = random_arguments(program.parameters, state, rng)
    if arguments is None:  # the scene has nothing for it: another program
        return random_call(expert, observation, shown, rng, demonstrated)
    return program, arguments


def with_distractor(observation: Observation, rng: np.random.Generator) -> Observation:
    """Return the observation with one more object, a copy of another, far from all if there is room."""
    movable = [obj for obj in observation.objects if obj.movable]
    if not movable:
        return observation
    like = movable[int(rng.integers(len(movable)))]
    names = (obj.name for obj in observation.objects if not obj.roomy)
    taken = [observation.gripper, *(observation.positions[n] for n in names if n in observation.positions)]
    for _ in range(DRAWS):
        x, y = (float(rng.uniform(*bounds)) for bounds in TABLE)
        if all(hypot(x - other[0], y - other[1]) > ASIDE for other in taken):
            extra = replace(like, name=DISTRACTOR)
            places = {**observation.positions, DISTRACTOR: (x, y, like.size[2] / 2)}
            return replace(observation, objects=(*observation.objects, extra), positions=places)
    return observation
