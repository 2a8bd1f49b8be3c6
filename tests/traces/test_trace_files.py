"""A trace is complete up to its last complete line, and records what happened."""

from __future__ import annotations

import io
import json
import re
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np
import pytest
from old_files import VERSION_2
from trees import CUBE, SEEN, headed

from ntp_dsl.datasets.recording import header
from ntp_dsl.execution.interpreter import Interpreter, Limits
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import Argument, DeclaredFact, Observation, Record, SceneObject
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.traces.decision import NO_DECISION, Alternative, Answer, Decision, FactProbability
from ntp_dsl.traces.reader import parse_trace, read_trace
from ntp_dsl.traces.schema import ROOT, Attribution, Call, CallOutcome, Ending, Execution, PolicyKind
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.perturbed_starts import perturbed_start
from ntp_dsl.worlds.protocol import Disturbances, Scene

HERE = Path("a.trace.jsonl")
DISTURBED = Disturbances(slips=0.3, pushes=0.3)


HEADER = b'{"format": "ntp-trace", "version": 3}\n'
STATE = b'{"event": "state", "id": 0, "positions": {}, "gripper": [0, 0, 1], "closed": false}\n'


OLD = b'{"format": "ntp-trace", "version": 2, "things": []}\n'


def start_episode(registry: Registry, seed: int) -> tuple[KinematicWorld, Scene]:
    rng = np.random.default_rng(seed)
    instance = draw(registry, find_task(registry, "few_placements"), rng)
    scene = perturbed_start(instance.objects, rng)
    world = KinematicWorld()
    world.reset(scene, seed, DISTURBED)
    return world, scene


def recorded(registry: Registry, seed: int = 5) -> bytes:
    world, _ = start_episode(registry, seed)
    instance = draw(registry, find_task(registry, "few_placements"), np.random.default_rng(seed))
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(header(registry, instance, seed, PolicyKind.SCRIPTED))
    policy = ScriptedPolicy(Expert(registry))
    limits = Limits(primitives=40)
    run = Interpreter(registry, policy, world, writer, limits).run(instance.program, instance.arguments)
    writer.end(run.end())
    return stream.getvalue().encode()


@pytest.fixture(scope="module")
def text(stacking: Registry) -> bytes:
    return recorded(stacking)


def test_a_trace_cut_at_any_byte_is_read_up_to_its_last_complete_line(text: bytes) -> None:
    whole = parse_trace(text, HERE)
    first = text.index(b"\n") + 1
    for end in [*range(first, min(first + 2000, len(text))), *range(first, len(text), 97)]:
        cut = parse_trace(text[:end], HERE)
        lines = text[:end].count(b"\n")
        assert cut.end is None and len(cut.calls) <= len(whole.calls)
        assert [c.name for c in cut.calls] == [c.name for c in whole.calls[: len(cut.calls)]]
        assert cut.states == whole.states[: len(cut.states)]
        assert len(cut.calls) + len(cut.states) <= lines
    assert whole.end is not None


def test_a_trace_needs_one_complete_line(text: bytes) -> None:
    for end in [0, 1, 40, text.index(b"\n")]:
        with pytest.raises(NtpError, match="no complete line"):
            parse_trace(text[:end], HERE)


def call(number: object = 0, parent: object = ROOT, **facts: object) -> bytes:
    row = {"event": "call", "id": number, "parent": parent, "kind": "program", "name": "go"}
    row |= {"arguments": [], "scope": None, "frame": 0, "state": 0} | facts
    return json.dumps(row).encode() + b"\n"


def returned(number: object = 0, **facts: object) -> bytes:
    row = {"event": "return", "id": number, "outcome": "done", "frame": 0} | facts
    return json.dumps(row).encode() + b"\n"


@pytest.mark.parametrize(
    "content, found",
    [
        (b"library a\n", "a.trace.jsonl:1: expected a trace"),
        (b"\x00" * 5000 + b"\n", "a.trace.jsonl:1: expected a trace"),
        (b"\xff\xfe\n", "expected a trace"),
        (b"[" * 100_000 + b"\n", "expected a trace"),
        (b"[1]\n", "expected a trace"),
        (b'{"tasks": []}\n', "expected a trace"),
        (b'{"format": "ntp-trace", "version": 99}\n', "found 99; it was written by a newer ntp: update ntp"),
        (b'{"format": "ntp-trace", "version": 1}\n', "found 1; record it again"),
        (b'{"format": "ntp-trace", "version": "3"}\n', "found '3'"),
        (b'{"format": "ntp-trace", "version": 3, "objects": [{"name": 3}]}\n', r"`str`, got `int`"),
        (b'{"format": "ntp-trace", "version": 2}\n', "jsonl:1: .* it lacks 'things'"),
        (b'{"format": "ntp-trace", "version": 2, "things": [{"name": 3}]}\n', "it lacks 'size'"),
        (b'{"format": "ntp-trace", "version": 2, "things": 3}\n', "jsonl:1: not a line"),
        (OLD + b'{"event": "call", "id": 0, "arguments": 3}\n', "jsonl:2: not a line"),
        (OLD + STATE + b'{"event": "end", "reason": 3}\n', "jsonl:3: not a line"),
        (HEADER + b'{"event": "call"}\n', "jsonl:2: .* missing required field `id`"),
        (HEADER + b'{"id": 3}\n', "jsonl:2: .* missing required field `event`"),
        (HEADER + b"[1]\n", "jsonl:2: .* Expected `object`"),
        (HEADER + b"library a\n", "jsonl:2: not a line of a trace: JSON is malformed"),
        (HEADER + call(), "there is no state 0"),
        (HEADER + STATE + STATE, "expected state 1"),
        (HEADER + STATE.replace(b"[0, 0, 1]", b"[0, 0, NaN]"), "not a line of a trace: JSON is malformed"),
        (HEADER + STATE.replace(b"[0, 0, 1]", b"[0, 0, 1e999]"), "out of range"),
        (HEADER + STATE.replace(b"[0, 0, 1]", b"[0, 0]"), "of length 3"),
        (HEADER + STATE + call(1), "expected call 0, found 1"),
        (HEADER + STATE + call(-1), r"`int` >= 0 - at `\$.id`"),
        (HEADER + STATE + call(True), r"`int`, got `bool` - at `\$.id`"),
        (HEADER + STATE + call(parent=7), "is made by 7"),
        (HEADER + STATE + call(kind="api") + call(1, 0), "a primitive cannot make calls"),
        (HEADER + STATE + call(kind="<script>"), "Invalid enum value"),
        (HEADER + STATE + call(name=3), r"`str`, got `int` - at `\$.name`"),
        (HEADER + STATE + call(arguments={"a": 1}), r"at `\$.arguments`"),
        (HEADER + STATE + call(arguments=[None]), r"at `\$.arguments\[0\]`"),
        (HEADER + STATE + call(arguments=json.loads("[" * 900 + "]" * 900)), r"at `\$.arguments"),
        (HEADER + STATE + call(scope=[5, 2]), "expected a scope"),
        (HEADER + STATE + call(scope=[0, 1, 2]), r"at `\$.scope`"),
        (HEADER + STATE + call(decision=3), r"at `\$.decision`"),
        (HEADER + STATE + returned(), "none is running"),
        (HEADER + STATE + call() + call(1, 0) + returned(0), "call 0 returns, but 1 is running"),
        (HEADER + STATE + call() + returned(outcome=None), r"at `\$.outcome`"),
        (HEADER + HEADER.replace(b"{", b'{"event": "header", ', 1), "a second header"),
    ],
)
def test_an_invalid_trace_is_refused_in_one_sentence(content: bytes, found: str) -> None:
    with pytest.raises(NtpError, match=found) as caught:
        parse_trace(content, HERE)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 300


def test_unknown_events_and_fields_are_skipped() -> None:
    obj = {"name": "a", "type": "Cup", "size": [0.1, 0.1, 0.1], "weight": 3}
    header = {"format": "ntp-trace", "version": 3, "objects": [obj], "weather": "fair"}
    odd = b'{"event": "weather", "id": "fair"}\n'
    text = json.dumps(header).encode() + b"\n" + odd + STATE + call(mood="good") + returned(mood="bad")
    trace = parse_trace(text + odd, HERE)
    assert [obj.name for obj in trace.header.objects] == ["a"]
    assert trace.calls[0].outcome is CallOutcome.DONE


def test_a_hundred_thousand_calls_are_read_as_they_were_written() -> None:
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(headed())
    seen = Observation((), {}, (0.0, 0.0, 1.0), False)
    root = writer.call(ROOT, "program", "build", (), None, 0, writer.state(seen), NO_DECISION)
    for number in range(100_000):
        state = writer.state(Observation((), {}, (0.0, 0.0, float(number % 7)), False))
        writer.returned(writer.call(root, "api", "go", ("a",), None, 0, state, NO_DECISION), "achieved", 0)
    writer.returned(root, "done", 0)
    start = process_time()
    trace = parse_trace(stream.getvalue().encode(), HERE)
    assert process_time() - start < 20
    assert len(trace.children(root)) == 100_000 and trace.states[-1].gripper == (0, 0, 99_999 % 7)


def test_motion_and_pictures_are_read_as_they_were_written() -> None:
    obj = SceneObject("a", "Cup", (0.1, 0.1, 0.1))
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(headed())
    for frame in range(4):
        places = {"a": (0.1 * max(frame - 1, 0), 0.0, 0.0)}
        writer.frame(0.1 * frame, Observation((obj,), places, (0.0, 0.0, 1.0), frame == 3))
    writer.picture(2, "frames/00002.jpg")
    trace = parse_trace(stream.getvalue().encode(), HERE)
    assert [motion.positions for motion in trace.motions] == [
        {"a": (0.0, 0.0, 0.0)}, {}, {"a": (0.1, 0.0, 0.0)}, {"a": (0.2, 0.0, 0.0)},
    ]  # fmt: skip
    assert trace.motions[3].closed and trace.motions[3].time == pytest.approx(0.3)
    assert trace.pictures == [(2, "frames/00002.jpg")]


def test_a_missing_file_is_reported_in_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(NtpError, match="none.jsonl: cannot be read"):
        read_trace(tmp_path / "none.jsonl")


def test_calls_form_a_tree_and_every_one_returned(text: bytes) -> None:
    trace = parse_trace(text, HERE)
    for call in trace.calls:
        assert call.parent == ROOT or call.parent < call.id
        assert call.kind == "program" or not trace.children(call.id)
        assert call.outcome and 0 <= call.state < len(trace.states)


def test_a_trace_names_the_line_that_its_expert_followed(text: bytes) -> None:
    calls = [call for call in parse_trace(text, HERE).calls if call.parent != ROOT]
    sources = {call.decision.source.split(":")[0] for call in calls}
    assert sources == {"block_stacking.ntp", "tabletop.ntp"}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_same_seed_gives_the_same_trace(stacking: Registry, seed: int) -> None:
    one, other = (re.sub(rb'"seconds":[^,}]*', b"", recorded(stacking, seed)) for _ in range(2))
    assert one == other


@pytest.mark.parametrize("seed", range(8))
def test_a_trace_replayed_gives_the_same_states_and_outcomes(stacking: Registry, seed: int) -> None:
    trace = parse_trace(recorded(stacking, seed), HERE)
    world, _ = start_episode(stacking, seed)
    replayed = replay(trace, world)
    outcomes = [call.outcome for call in trace.calls if call.kind == "api"]
    assert [outcome for _, outcome in replayed] == outcomes
    for call, (state, _) in zip(primitives(trace), replayed, strict=True):
        assert state == row(trace.states[call.state].positions)


def primitives(trace: Trace) -> list[Call]:
    return [call for call in trace.calls if call.kind == "api"]


def replay(trace: Trace, world: KinematicWorld) -> list[tuple[object, str]]:
    """Execute each primitive again, and return the state it was called in and its outcome."""
    found = []
    for call in trace.calls:
        if call.kind == "api":
            before = row(world.truth().positions)
            outcome = world.call(call.name, call.arguments)
            found.append((before, "achieved" if outcome.achieved else str(outcome.failure)))
    return found


def row(positions: object) -> object:
    assert isinstance(positions, dict)
    return {name: tuple(round(x, 5) for x in place) for name, place in positions.items()}


@pytest.mark.parametrize(
    "argument",
    ["block_1", 0.25, Record("Placement", (("item", "a"), ("support", "b"))), ()],
)
def test_arguments_are_read_as_they_were_written(argument: Argument) -> None:
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(headed(arguments=(argument,)))
    writer.call(ROOT, "program", "go", (argument,), None, 0, writer.state(SEEN), NO_DECISION)
    trace = parse_trace(stream.getvalue().encode(), HERE)
    assert trace.header.arguments == (argument,) == trace.calls[0].arguments


def test_an_observation_is_read_as_it_was_written() -> None:
    seen = replace(
        SEEN,
        unreachable=frozenset(["block_0"]),
        orientations={"block_0": (0.0, 0.6, 0.0, 0.8)},
        deviations={"block_0": 0.004},
        facts=frozenset([DeclaredFact("open", ("drawer_0",)), DeclaredFact("lit", ())]),
    )
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(headed(objects=(CUBE,)))
    writer.state(seen)
    assert list(parse_trace(stream.getvalue().encode(), HERE).states) == [seen]


LEARNED_DECISION = Decision(
    source="a.ntp:3",
    seconds=0.01,
    probability=0.5,
    end_probability=0.1,
    callees=(Alternative("pick", 0.9), Alternative("place", 0.1)),
    arguments=((Alternative("a", 1.0),), (Alternative(0.25, 1.0),)),
    scopes=(Alternative(None, 0.6), Alternative((2, 5), 0.4)),
    facts=(FactProbability("on(a, b)", 0.3, False), FactProbability("clear(a)", 1.0)),
    answer=Answer("pick", True, ("a", 0.25), (2, 5)),
)


def test_a_decision_is_read_as_it_was_written() -> None:
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(headed())
    state = writer.state(SEEN)
    number = writer.call(ROOT, "program", "go", (), None, 0, state, LEARNED_DECISION)
    writer.returned(number, CallOutcome.DONE, 3, state, LEARNED_DECISION)
    (call,) = parse_trace(stream.getvalue().encode(), HERE).calls
    assert call.decision == call.return_decision == LEARNED_DECISION


def test_evidence_may_be_a_numpy_array() -> None:
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(headed())
    number = writer.call(ROOT, "api", "go", (), None, 0, writer.state(SEEN), NO_DECISION)
    measured = {"tilt": np.float64(0.5), "place": np.array([1.0, 2.0]), "file": Path("a")}
    writer.returned(number, CallOutcome.ACHIEVED, 3, execution=Execution(evidence=measured))
    (call,) = parse_trace(stream.getvalue().encode(), HERE).calls
    assert call.execution.evidence == {"tilt": 0.5, "place": [1.0, 2.0], "file": "a"}


def test_a_trace_of_version_2_is_converted() -> None:
    trace = parse_trace(VERSION_2, HERE)
    assert trace.header.goal == (Record("Placement", (("item", "a"), ("support", "b"))),)
    assert trace.header.arguments == (trace.header.goal,) and trace.header.policy is PolicyKind.LEARNED
    assert trace.header.demonstration is not None and trace.header.demonstration.calls is not None
    assert [each.name for each in trace.header.demonstration.calls.walk()] == ["build", "pick"]
    build, push = trace.calls
    assert build.arguments == trace.header.arguments and build.outcome is CallOutcome.DONE
    assert build.return_decision is not None and build.return_decision.end_probability == 0.9
    assert push.decision.callees == (Alternative("push", 0.7), Alternative("pick", 0.3))
    assert push.decision.arguments == (
        (Alternative("a", 0.6), Alternative("b", 0.4)),
        (Alternative("left", 1.0),),
        (Alternative(0.1, 1.0),),
    )
    assert push.decision.scopes == (Alternative((0, 4), 0.8), Alternative(None, 0.2))
    assert push.outcome is CallOutcome.GRASP_FAILED and push.execution.disturbances == ("slip a",)
    assert push.execution.planning == 0.25 and push.execution.evidence == {"width": 0.01}
    assert trace.states[0].by_name["a"].size == (0.05, 0.09, 0.03)
    assert trace.end is not None and trace.end.ending is Ending.UNFINISHED and trace.end.success is False
    assert trace.end.attributed_to is Attribution.GRASP and trace.end.verdict == "on(a, b) does not hold"


@pytest.mark.parametrize("constant", ["NaN", "Infinity", "-Infinity"])
def test_what_the_writer_of_version_2_measured_is_read_whatever_it_was(constant: str) -> None:
    text = VERSION_2.replace(b'"width": 0.01', f'"width": {constant}'.encode())
    assert text != VERSION_2
    assert parse_trace(text, HERE).calls[1].execution.evidence == {"width": constant}


@pytest.mark.parametrize(
    "line, said",
    [
        (b'{"event": "end", "reason": null}', "expected the fields of version 2, found {.*null}"),
        (b"[1]", "expected an object with an 'event'"),
        (b'{"event": "state", "id": 1e999}', "expected a number that fits a float, found 1e999"),
    ],
)
def test_a_damaged_line_of_version_2_is_told_so_in_words(line: bytes, said: str) -> None:
    with pytest.raises(NtpError, match=f"jsonl:2: not a line of a trace: {said}"):
        parse_trace(OLD + line + b"\n", HERE)
