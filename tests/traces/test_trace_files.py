"""A trace is whole up to its last whole line, and says what happened."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path
from time import process_time

import numpy as np
import pytest

from ntp_dsl.datasets.recording import header
from ntp_dsl.execution.interpreter import Interpreter, Limits
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import Observation, Record, Thing
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.traces.reader import parse_trace, read_trace
from ntp_dsl.traces.schema import ROOT, Call, Trace, from_json, to_json
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.protocol import Disturbances, Scene
from ntp_dsl.worlds.starts import scrambled

HERE = Path("a.trace.jsonl")
TROUBLE = Disturbances(slips=0.3, pushes=0.3)


HEADER = b'{"format": "ntp-trace", "version": 2, "things": []}\n'
STATE = b'{"event": "state", "id": 0, "positions": {}, "gripper": [0, 0, 1], "closed": false}\n'


def begun(registry: Registry, seed: int) -> tuple[KinematicWorld, Scene]:
    rng = np.random.default_rng(seed)
    instance = draw(registry, find_task(registry, "few_placements"), rng)
    scene = scrambled(instance.things, rng)
    world = KinematicWorld()
    world.reset(scene, seed, TROUBLE)
    return world, scene


def recorded(registry: Registry, seed: int = 5) -> bytes:
    world, _ = begun(registry, seed)
    instance = draw(registry, find_task(registry, "few_placements"), np.random.default_rng(seed))
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(**header(registry, instance, seed, "scripted"))
    policy = ScriptedPolicy(Expert(registry))
    limits = Limits(primitives=40)
    run = Interpreter(registry, policy, world, writer, limits).run(instance.program, instance.arguments)
    writer.end(done=run.done, reason=run.reason, primitives=run.primitives)
    return stream.getvalue().encode()


@pytest.fixture(scope="module")
def text(stacking: Registry) -> bytes:
    return recorded(stacking)


def test_a_trace_cut_at_any_byte_reads_up_to_its_last_whole_line(text: bytes) -> None:
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


def test_a_trace_without_one_whole_line_is_none(text: bytes) -> None:
    for end in [0, 1, 40, text.index(b"\n")]:
        with pytest.raises(NtpError, match="not one whole line"):
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
        (b"library a\n", "a.trace.jsonl:1: expected a line of JSON"),
        (b"\x00" * 5000 + b"\n", "a.trace.jsonl:1: expected a line of JSON"),
        (b"\xff\xfe\n", "expected a line of JSON"),
        (b"[" * 100_000 + b"\n", "expected a line of JSON"),
        (b"[1]\n", "expected a JSON object"),
        (b'{"tasks": []}\n', "expected a trace"),
        (b'{"format": "ntp-trace", "version": 99}\n', "found 99; a newer ntp made it: update ntp"),
        (b'{"format": "ntp-trace", "version": 1}\n', "found 1; make it anew"),
        (b'{"format": "ntp-trace", "version": "2"}\n', "found '2'"),
        (b'{"format": "ntp-trace", "version": 2}\n', "jsonl:1: .* it lacks 'things'"),
        (b'{"format": "ntp-trace", "version": 2, "things": [{"name": 3}]}\n', "a name and a type"),
        (HEADER + b'{"event": "call"}\n', "jsonl:2: .* it lacks"),
        (HEADER + b'{"id": 3}\n', "jsonl:2: .* it lacks"),
        (HEADER + b"[1]\n", "jsonl:2: expected a JSON object"),
        (HEADER + call(), "there is no state 0"),
        (HEADER + STATE + STATE, "expected state 1"),
        (HEADER + STATE.replace(b"[0, 0, 1]", b"[0, 0, NaN]"), "expected three numbers"),
        (HEADER + STATE.replace(b"[0, 0, 1]", b"[0, 0, 1e999]"), "expected three numbers"),
        (HEADER + STATE + call(1), "expected call 0, found 1"),
        (HEADER + STATE + call(-1), "expected id to be a number"),
        (HEADER + STATE + call(True), "expected id to be a number"),
        (HEADER + STATE + call(parent=7), "is made by 7"),
        (HEADER + STATE + call(kind="api") + call(1, 0), "a primitive calls nothing"),
        (HEADER + STATE + call(kind="<script>"), "expected a program or an api"),
        (HEADER + STATE + call(name=3), "expected name to be a text"),
        (HEADER + STATE + call(arguments={"a": 1}), "expected arguments to be a list"),
        (HEADER + STATE + call(arguments=[None]), "is not an argument"),
        (HEADER + STATE + call(arguments=json.loads("[" * 900 + "]" * 900)), "too deeply"),
        (HEADER + STATE + call(scope=[5, 2]), "expected two frames"),
        (HEADER + STATE + call(scope=[0, 1, 2]), "expected two frames"),
        (HEADER + STATE + call(decision=3), "expected decision to be an object"),
        (HEADER + STATE + returned(), "none is running"),
        (HEADER + STATE + call() + call(1, 0) + returned(0), "call 0 returns, but 1 is running"),
        (HEADER + STATE + call() + returned(outcome=None), "expected outcome to be a text"),
        (HEADER + HEADER.replace(b"{", b'{"event": "header", ', 1), "a second header"),
    ],
)
def test_what_is_not_a_trace_is_told_in_one_sentence(content: bytes, found: str) -> None:
    with pytest.raises(NtpError, match=found) as caught:
        parse_trace(content, HERE)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 300


def test_what_this_version_does_not_know_is_passed_over() -> None:
    thing = {"name": "a", "type": "Cup", "size": [0.1, 0.1, 0.1], "weight": 3}
    header = {"format": "ntp-trace", "version": 2, "things": [thing], "weather": "fair"}
    odd = b'{"event": "weather", "id": "fair"}\n'
    text = json.dumps(header).encode() + b"\n" + odd + STATE + call(mood="good") + returned(mood="bad")
    trace = parse_trace(text + odd, HERE)
    assert [thing.name for thing in trace.things] == ["a"] and trace.header["weather"] == "fair"
    assert trace.calls[0].outcome == "done" and trace.calls[0].details == {"mood": "bad"}


def test_a_hundred_thousand_calls_are_read_as_they_were_written() -> None:
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(things=[])
    seen = Observation((), {}, (0.0, 0.0, 1.0), False)
    root = writer.call(ROOT, "program", "build", (), None, 0, writer.state(seen), {})
    for number in range(100_000):
        state = writer.state(Observation((), {}, (0.0, 0.0, float(number % 7)), False))
        writer.returned(writer.call(root, "api", "go", ("a",), None, 0, state, {}), "achieved", 0)
    writer.returned(root, "done", 0)
    begun = process_time()
    trace = parse_trace(stream.getvalue().encode(), HERE)
    assert process_time() - begun < 20
    assert len(trace.children(root)) == 100_000 and trace.states[-1].gripper == (0, 0, 99_999 % 7)


def test_motion_and_pictures_are_read_as_they_were_written() -> None:
    thing = Thing("a", "Cup", (0.1, 0.1, 0.1))
    stream = io.StringIO()
    writer = TraceWriter(stream)
    writer.header(things=[])
    for frame in range(4):
        places = {"a": (0.1 * max(frame - 1, 0), 0.0, 0.0)}
        writer.frame(0.1 * frame, Observation((thing,), places, (0.0, 0.0, 1.0), frame == 3))
    writer.picture(2, "frames/00002.jpg")
    trace = parse_trace(stream.getvalue().encode(), HERE)
    assert [motion.positions for motion in trace.motions] == [
        {"a": (0.0, 0.0, 0.0)}, {}, {"a": (0.1, 0.0, 0.0)}, {"a": (0.2, 0.0, 0.0)},
    ]  # fmt: skip
    assert trace.motions[3].closed and trace.motions[3].time == pytest.approx(0.3)
    assert trace.pictures == [(2, "frames/00002.jpg")]


def test_a_file_that_is_not_there_is_told_in_one_sentence(tmp_path: Path) -> None:
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
    sources = {str(call.decision["source"]).split(":")[0] for call in calls}
    assert sources == {"block_stacking.ntp", "tabletop.ntp"}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_same_seed_gives_the_same_trace(stacking: Registry, seed: int) -> None:
    one, other = (re.sub(rb'"seconds":[^,}]*', b"", recorded(stacking, seed)) for _ in range(2))
    assert one == other


@pytest.mark.parametrize("seed", range(8))
def test_a_trace_replayed_gives_the_same_states_and_outcomes(stacking: Registry, seed: int) -> None:
    trace = parse_trace(recorded(stacking, seed), HERE)
    world, _ = begun(stacking, seed)
    replayed = replay(trace, world)
    outcomes = [call.outcome for call in trace.calls if call.kind == "api"]
    assert [outcome for _, outcome in replayed] == outcomes
    for call, (state, _) in zip(primitives(trace), replayed, strict=True):
        assert state == row(trace.states[call.state].positions)


def primitives(trace: Trace) -> list[Call]:
    return [call for call in trace.calls if call.kind == "api"]


def replay(trace: Trace, world: KinematicWorld) -> list[tuple[object, str]]:
    """Each primitive again: the state that it was called in, and what came of it."""
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
def test_arguments_come_back_as_they_were(argument: str | float | Record) -> None:
    assert from_json(json.loads(json.dumps(to_json(argument)))) == argument
