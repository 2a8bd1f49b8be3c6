"""A replay compares a policy's decision at every state of a trace, each independently."""

from __future__ import annotations

import io
import json
from dataclasses import replace
from pathlib import Path

import pytest
from trees import HERE, recorded

from ntp_dsl.cli.app import run
from ntp_dsl.execution.replay import Replay
from ntp_dsl.language.registry import Registry
from ntp_dsl.policies.expert import Expert
from ntp_dsl.policies.protocol import Barred, Choice, Frame, Policy
from ntp_dsl.policies.scripted import ScriptedPolicy
from ntp_dsl.semantics.observation import Argument
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.comparison.teacher_forcing import count_answers
from ntp_dsl.traces.reader import parse_trace
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter
from ntp_dsl.worlds.protocol import World


@pytest.fixture(scope="module")
def trace(stacking: Registry) -> Trace:
    return parse_trace(recorded(stacking, 5), HERE)


def replayed(registry: Registry, policy: Policy, trace: Trace) -> Trace:
    stream = io.StringIO()
    Replay(registry, policy, trace).write(TraceWriter(stream))
    return parse_trace(stream.getvalue().encode(), HERE)


class Stubborn:
    """An expert that answers a wrong object in one of its decisions."""

    def __init__(self, expert: Expert, number: int, answer: Choice) -> None:
        self._script, self._left, self._answer = ScriptedPolicy(expert), number, answer

    def root(self, program: str, arguments: tuple[Argument, ...]) -> Frame:
        return self._script.root(program, arguments)

    def decide(self, frame: Frame, world: World, barred: Barred = frozenset()) -> Choice:
        self._left -= 1
        right = self._script.decide(frame, world, barred)
        return replace(self._answer, seen=right.seen) if self._left == 0 else right


@pytest.mark.parametrize("seed", range(6))
def test_an_expert_answers_as_in_its_own_trace(stacking: Registry, seed: int) -> None:
    trace = parse_trace(recorded(stacking, seed), HERE)
    policy = ScriptedPolicy(Expert(stacking))
    again = replayed(stacking, policy, trace)
    programs = [call for call in trace.calls if call.is_program and call.end_state is not None]
    assert count_answers(again) == len(programs) + sum(call.parent >= 0 for call in trace.calls)
    assert compare(trace, again, scopes=False).first is None


@pytest.mark.parametrize("number", [1, 7, 30])
def test_one_wrong_answer_is_found_and_has_no_consequences(
    stacking: Registry, trace: Trace, number: int
) -> None:
    wrong = Choice("grasp", ("nothing",))
    again = replayed(stacking, Stubborn(Expert(stacking), number, wrong), trace)
    (found,) = compare(trace, again, scopes=False).divergences
    asked_of = [
        (call, returns)
        for call, returns in trace.events()
        if (call.is_program and call.end_state is not None if returns else call.parent >= 0)
    ]
    call, returns = asked_of[number - 1]
    assert found.answer is not None and found.answer.callee == "grasp"
    assert (found.a, found.caller_a) == ((None, call.id) if returns else (call.id, call.parent))
    right = DivergenceKind.ARGUMENT if call.name == "grasp" else DivergenceKind.PROGRAM
    assert found.kind is (DivergenceKind.TOO_LATE if returns else right) and found.attributed_to == "decision"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recorded")
    assert run(["record", "block_stacking", "few_placements", "-n", "1", "--out", str(path)]) == 0
    return path


def test_the_shipped_checkpoint_answers_nearly_as_the_expert(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, out = folder / "episode_00000.trace.jsonl", tmp_path / "answers.jsonl"
    status = run(["trace", "replay", str(file), "--json", "--out", str(out)])
    document = json.loads(capsys.readouterr().out)
    assert document["right"] >= 0.85 * document["asked"] > 0
    assert (
        status == int(document["differ"])
        and sum(document["counts"].values()) == document["asked"] - document["right"]
    )
    assert run(["trace", "diff", str(file), str(out), "--json"]) == status
    assert json.loads(capsys.readouterr().out)["counts"] == document["counts"]


def test_the_expert_answers_with_the_same_scopes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "replay", str(folder / "episode_00000.trace.jsonl"), "--expert"]) == 0
    assert "decisions as in the trace\nthe same" in capsys.readouterr().out


def test_misuse_says_what_is_missing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = folder / "episode_00000.trace.jsonl"
    header, rest = file.read_text().split("\n", 1)
    for change, message in [
        ({"demonstration": None}, "give --demo FILE"),
        ({"registry": "other"}, "another version of library 'block_stacking'"),
        ({"library": "nowhere"}, "give its path with --library"),
        ({"demonstration": {"file": "gone.parquet", "frames": 3}}, "gone.parquet: no such demonstration"),
    ]:
        changed = folder / "changed.jsonl"
        changed.write_text(json.dumps({**json.loads(header), **change}) + "\n" + rest)
        assert run(["trace", "replay", str(changed)]) == 2
        assert message in capsys.readouterr().err


def _altered(file: Path, change: dict[str, object], number: int | None, name: str) -> Path:
    """Write a trace again with another header, or with another call of that number."""
    rows = [json.loads(line) for line in file.read_text().splitlines()]
    at = 0 if number is None else [n for n, row in enumerate(rows) if row["event"] == "call"][number]
    rows[at] |= change
    changed = file.with_name(name)
    changed.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return changed


DAMAGED: list[tuple[dict[str, object], int | None, str]] = [
    ({"name": "nope"}, 1, "call 1 is of the program 'nope', which library 'block_stacking' lacks"),
    ({"arguments": []}, 1, "expected 2 arguments, found 0"),
    ({"arguments": ["block_0", "zz"]}, 1, "expected the name of an object in the scene"),
    ({"arguments": ["block_0", 3.0]}, 1, "expected the name of an object in the scene"),
    ({"arguments": [[{"type": "Zz", "fields": []}]]}, 0, "found [()]"),
    ({"objects": []}, None, "expected the name of an object in the scene"),
    (
        {"objects": [{"name": "a", "type": "Zz", "size": [0.1, 0.1, 0.1]}]},
        None,
        "'a' is a Zz, a type that library",
    ),
]


@pytest.mark.parametrize("change, number, said", DAMAGED)
@pytest.mark.parametrize("asked", [[], ["--expert"]])
def test_a_trace_that_no_policy_can_be_asked_at_is_refused(
    folder: Path,
    change: dict[str, object],
    number: int | None,
    said: str,
    asked: list[str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    changed = _altered(folder / "episode_00000.trace.jsonl", change, number, "damaged.jsonl")
    assert run(["trace", "replay", str(changed), *asked]) == 2
    assert said in capsys.readouterr().err


def test_a_demonstration_that_is_not_the_traces_is_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = folder / "episode_00000.trace.jsonl"
    words = ["record", "block_stacking", "few_placements", "-n", "1", "--seed", "9", "--out", str(tmp_path)]
    assert run(words) == 0
    other = tmp_path / "episode_00000.demo.parquet"
    assert run(["trace", "replay", str(file), "--demo", str(other)]) == 2
    assert "the trace is of a demonstration of " in capsys.readouterr().err
    far = _altered(file, {"scope": [0, 100_000]}, 1, "far.jsonl")
    assert run(["trace", "replay", str(far)]) == 2
    assert "a scope up to frame 100000, and the demonstration has" in capsys.readouterr().err


def test_answers_are_not_written_over_what_is_asked_about(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, demo = folder / "episode_00000.trace.jsonl", folder / "episode_00000.demo.parquet"
    before = file.read_bytes(), demo.read_bytes()
    for out in (folder / ".." / folder.name / file.name, demo):
        assert run(["trace", "replay", str(file), "--expert", "--out", str(out)]) == 2
        assert "would be overwritten; give another file" in capsys.readouterr().err
    assert (file.read_bytes(), demo.read_bytes()) == before
