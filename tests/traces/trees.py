"""Call trees for tests: built from real traces, edited, and written again."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ntp_dsl.datasets.recording import RecordedDemonstration, demonstrate, header
from ntp_dsl.execution.interpreter import Interpreter, Limits
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import Argument, Observation, SceneObject
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.traces.decision import Decision
from ntp_dsl.traces.reader import parse_trace
from ntp_dsl.traces.schema import FORMAT, ROOT, VERSION, End, Ending, Header, PolicyKind
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.perturbed_starts import perturbed_start
from ntp_dsl.worlds.protocol import Disturbances

HERE = Path("a.trace.jsonl")
DISTURBED = Disturbances(slips=0.3, pushes=0.3)
CUBE = SceneObject("block_0", "Block", (0.05, 0.05, 0.05))
SEEN = Observation((CUBE,), {"block_0": (0.5, 0.0, 0.025)}, (0.4, 0.0, 0.4), False)


DONE = End(ending=Ending.DONE)


def headed(**facts: Any) -> Header:
    """Return a header of the current version."""
    return Header(format=FORMAT, version=VERSION, **facts)


def recorded(registry: Registry, seed: int, task: str = "few_placements", primitives: int = 40) -> bytes:
    """Record a scripted episode from a perturbed start, with slips, pushes and scopes."""
    rng = np.random.default_rng(seed)
    instance = draw(registry, find_task(registry, task), rng)
    world, expert = KinematicWorld(), Expert(registry)
    recorded = demonstrate(registry, expert, world, instance, seed)
    world.reset(perturbed_start(instance.objects, rng), seed, DISTURBED)
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(header(registry, instance, seed, PolicyKind.SCRIPTED))
    policy = ScriptedPolicy(expert, recorded.calls if isinstance(recorded, RecordedDemonstration) else None)
    limits = Limits(primitives=primitives)
    run = Interpreter(registry, policy, world, writer, limits).run(instance.program, instance.arguments)
    writer.end(run.end())
    return stream.getvalue().encode()


@dataclass(eq=False)
class Node:
    """A call with the properties that are compared."""

    kind: str
    name: str
    arguments: tuple[Argument, ...] = ()
    scope: tuple[int, int] | None = None
    outcome: str | None = "done"
    kids: list[Node] = field(default_factory=list)

    @property
    def decision(self) -> tuple[object, ...]:
        return self.kind, self.name, self.arguments

    def walk(self) -> Iterator[Node]:
        waiting = [self]
        while waiting:
            node = waiting.pop()
            yield node
            waiting += reversed(node.kids)

    def copy(self) -> Node:
        kids = [kid.copy() for kid in self.kids]
        return Node(self.kind, self.name, self.arguments, self.scope, self.outcome, kids)


def tree(trace: Trace) -> Node:
    """Return the run, with its root calls below it."""
    run = Node("run", "run")
    nodes = {ROOT: run}
    for call in trace.calls:
        node = Node(call.kind, call.name, call.arguments, call.scope, call.outcome)
        nodes[call.id] = node
        nodes[call.parent].kids.append(node)
    return run


def written(run: Node, policy: str = "scripted") -> Trace:
    """Write the tree as a trace, and read it back."""
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(headed(library="sample", policy=policy, objects=(CUBE,)))
    state = writer.state(SEEN)
    waiting: list[tuple[Node | int, int, str | None]] = [(kid, ROOT, "") for kid in reversed(run.kids)]
    while waiting:
        node, parent, outcome = waiting.pop()
        if isinstance(node, int):
            writer.returned(node, outcome, 0, state=state)
            continue
        number = writer.call(
            parent, node.kind, node.name, node.arguments, node.scope, 0, state, Decision(source="a.ntp:1")
        )
        waiting.append((number, parent, node.outcome))
        waiting += [(kid, number, "") for kid in reversed(node.kids)]
    writer.end(DONE)
    return parse_trace(stream.getvalue().encode(), HERE)


def events(run: Node) -> list[tuple[Node, bool]]:
    """Yield calls and returns in order of execution: a node, and whether it returns."""
    found: list[tuple[Node, bool]] = []
    waiting = [(kid, False) for kid in reversed(run.kids)]
    while waiting:
        node, returns = waiting.pop()
        found.append((node, returns))
        if not returns:
            waiting.append((node, True))
            waiting += [(kid, False) for kid in reversed(node.kids)]
    return found


def prefix(run: Node, count: int) -> Node:
    """Return the tree after a number of events, with outcomes only of what had returned."""
    known = Node("run", "run")
    open_calls = [known]
    for node, returns in events(run)[:count]:
        if returns:
            open_calls.pop().outcome = node.outcome
        else:
            child = Node(node.kind, node.name, node.arguments, node.scope, outcome=None)
            open_calls[-1].kids.append(child)
            open_calls.append(child)
    return known
