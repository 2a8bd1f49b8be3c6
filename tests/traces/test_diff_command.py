"""`ntp trace diff`: the first divergence of two traces, as text and as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from msgspec.structs import replace as with_fields
from trees import DONE, headed

from ntp_dsl.cli.app import run
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.traces.comparison.comparison_rules import DivergenceKind
from ntp_dsl.traces.comparison.confidence import confidence
from ntp_dsl.traces.decision import NO_DECISION, Alternative, Decision
from ntp_dsl.traces.schema import ROOT, Call, Execution
from ntp_dsl.traces.writer import TraceWriter

THINGS = tuple(SceneObject(name, "Block", (0.05, 0.05, 0.05)) for name in "abc")
SOURCE = "library sample\nprogram build():\n    pick(a)\n    place(a)\n"
LIKELY = (Alternative("pick", 0.7), Alternative("place", 0.2))
SURE = Decision(end_probability=0.1, callees=LIKELY, source="s.ntp:3")
POINTED = with_fields(
    SURE, arguments=((Alternative("b", 0.6), Alternative("a", 0.3), Alternative("c", 0.1)),)
)


def seen(shift: float = 0.0) -> Observation:
    positions = {obj.name: (0.1 * n + shift, 0.0, 0.025) for n, obj in enumerate(THINGS)}
    return Observation(THINGS, positions, (0.0, 0.0, 0.4), False)


class Story:
    """Writes a trace call by call."""

    def __init__(self, path: Path, policy: str, start: float = 0.0) -> None:
        self.path, self.stream = path, path.open("w", encoding="utf-8")
        self.writer = TraceWriter(self.stream)
        sources = {"s.ntp": SOURCE}
        self.writer.header(headed(library="sample", policy=policy, objects=THINGS, sources=sources))
        self.state = self.writer.state(seen(start))
        self.root = self.writer.call(ROOT, "program", "build", (), None, 0, self.state, NO_DECISION)

    def api(self, name: str, obj: str, outcome: str = "achieved", **facts: object) -> Story:
        decision = facts.pop("decision", Decision(source="s.ntp:3"))
        assert isinstance(decision, Decision)
        number = self.writer.call(self.root, "api", name, (obj,), None, 0, self.state, decision)
        self.writer.returned(number, outcome, 0, execution=Execution(**facts))
        return self

    def drifts(self, shift: float) -> Story:
        self.state = self.writer.state(seen(shift))
        return self

    def end(self, **decision: object) -> Path:
        ending = Decision(source="s.ntp:2", **decision)
        self.writer.returned(self.root, "done", 0, self.state, ending)
        self.writer.end(DONE)
        self.stream.close()
        return self.path


@pytest.fixture
def right(tmp_path: Path) -> Path:
    return Story(tmp_path / "a.jsonl", "scripted").api("pick", "a").api("place", "a").end()


@pytest.fixture
def learned(tmp_path: Path) -> Story:
    return Story(tmp_path / "b.jsonl", "learned")


def first(capsys: pytest.CaptureFixture[str], a: Path, b: Path, *options: str) -> dict[str, object]:
    assert run(["trace", "diff", str(a), str(b), "--json", *options]) == 1
    document = json.loads(capsys.readouterr().out)
    assert document["differ"] and document["first"] == document["divergences"][0]
    found: dict[str, object] = document["first"]
    return found


def test_equal_traces_are_reported_as_the_same(
    capsys: pytest.CaptureFixture[str], right: Path, learned: Story
) -> None:
    same = learned.api("pick", "a").api("place", "a").end()
    assert run(["trace", "diff", str(right), str(same)]) == 0
    assert "the same: 3 calls" in capsys.readouterr().out
    assert run(["trace", "diff", str(right), str(same), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["first"] is None


def test_another_callee_is_reported_with_margin_rank_and_statement(
    capsys: pytest.CaptureFixture[str], right: Path, learned: Story
) -> None:
    other = learned.api("pick", "a").api("pick", "c", decision=SURE).end()
    found = first(capsys, right, other)
    assert (found["kind"], found["attributed_to"], found["source"]) == ("program", "decision", "s.ntp:3")
    assert found["statement"] == "pick(a)" and found["path"] == ["build"]
    assert (found["right_rank"], found["margin"]) == (2, 0.5)
    assert run(["trace", "diff", str(right), str(other)]) == 1
    output = capsys.readouterr().out
    assert "first divergence: program, attributed to decision" in output and "s.ntp:3:  pick(a)" in output
    assert "p=0.70; the right one has rank 2 (p=0.20); margin 0.50" in output
    assert "not shown: the 1 following calls of A, 1 of B" in output


def test_another_object_is_reported_with_the_rank_of_the_right_one(
    capsys: pytest.CaptureFixture[str], right: Path, learned: Story
) -> None:
    other = learned.api("pick", "b", decision=POINTED).api("place", "b").end()
    found = first(capsys, right, other)
    assert (found["kind"], found["right_rank"], found["right_probability"]) == ("argument", 2, 0.3)
    assert found["margin"] == pytest.approx(0.3)


@pytest.mark.parametrize(
    "right, actual, rank, chosen",
    [(("a", "left", 0.1), ("a", "right", 0.1), 2, 0.8), (("a", "left", 0.1), ("b", "left", 0.1), 3, 0.6)],
)
def test_a_member_is_ranked_among_members_and_an_object_among_objects(
    right: tuple[str | float, ...], actual: tuple[str | float, ...], rank: int, chosen: float
) -> None:
    obj = actual[0]
    decision = Decision(
        arguments=(
            (Alternative(obj, 0.6), Alternative("c", 0.3), Alternative("a", 0.1)),
            (Alternative("right", 0.8), Alternative("left", 0.2)),
            (Alternative(0.1, 1.0),),
        )
    )
    x, y = (Call(0, ROOT, "api", "push", given, None, 0, 0) for given in (right, actual))
    found = confidence(DivergenceKind.ARGUMENT, decision, x, y)
    assert (found.rank, found.chosen) == (rank, chosen)


def test_an_end_too_early_has_the_probability_of_the_end(
    capsys: pytest.CaptureFixture[str], right: Path, learned: Story
) -> None:
    found = first(capsys, right, learned.api("pick", "a").end(end_probability=0.8))
    assert (found["kind"], found["b"], found["margin"]) == ("end too early", None, pytest.approx(0.6))


def test_an_end_too_late_follows_the_programs_own_line(
    capsys: pytest.CaptureFixture[str], right: Path, learned: Story
) -> None:
    learned.api("pick", "a").api("place", "a").api("place", "c", decision=SURE)
    found = first(capsys, right, learned.end())
    assert (found["kind"], found["a"], found["statement"]) == ("end too late", None, "program build():")
    assert found["margin"] == pytest.approx(0.8)


@pytest.mark.parametrize(
    "outcome, disturbances, attribution",
    [
        ("no path", [], "planner"),
        ("grasp failed", [], "grasp"),
        ("place failed", [], "physics"),
        ("object dropped", ["slip a"], "disturbance"),
        ("not ready", [], "decision"),
    ],
)
def test_another_outcome_is_attributed_to_what_failed(
    capsys: pytest.CaptureFixture[str],
    right: Path,
    learned: Story,
    outcome: str,
    disturbances: list[str],
    attribution: str,
) -> None:
    other = learned.api("pick", "a", outcome, disturbances=disturbances).api("place", "a").end()
    found = first(capsys, right, other)
    assert (found["kind"], found["attributed_to"]) == ("outcome", attribution)


def test_a_wrong_decision_is_distinguished_from_different_states(
    capsys: pytest.CaptureFixture[str], right: Path, learned: Story, tmp_path: Path
) -> None:
    pushed = learned.api("pick", "a", disturbances=["push a"]).drifts(0.04).api("pick", "c").end()
    assert first(capsys, right, pushed)["attributed_to"] == "disturbance"
    drifted = Story(tmp_path / "c.jsonl", "learned").api("pick", "a").drifts(0.04).api("pick", "c")
    found = first(capsys, right, drifted.end())
    assert (found["attributed_to"], found["state_distance"]) == ("physics", pytest.approx(0.04))
    elsewhere = Story(tmp_path / "d.jsonl", "learned", start=0.2).api("pick", "c")
    assert first(capsys, right, elsewhere.end())["attributed_to"] == "start"


def test_all_divergences_are_reported_on_request(
    capsys: pytest.CaptureFixture[str], right: Path, learned: Story
) -> None:
    other = learned.api("pick", "b").api("place", "a", "place failed").end()
    assert run(["trace", "diff", str(right), str(other)]) == 1
    assert "1 more: outcome 1  (--all shows them)" in capsys.readouterr().out
    assert run(["trace", "diff", str(right), str(other), "--all"]) == 1
    assert "then: outcome, attributed to physics" in capsys.readouterr().out


def test_a_cut_off_file_is_not_a_decision(
    capsys: pytest.CaptureFixture[str], right: Path, learned: Story
) -> None:
    whole = learned.api("pick", "a").end()
    whole.write_bytes(whole.read_bytes().rsplit(b"\n", 3)[0] + b"\n")
    found = first(capsys, right, whole)
    assert (found["kind"], found["attributed_to"]) == ("cut off", "")


def test_scopes_can_be_ignored(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    paths = []
    for name, scope in (("a", (0, 10)), ("b", (50, 60))):
        story = Story(tmp_path / f"{name}.jsonl", "scripted")
        call = story.writer.call(story.root, "program", "go", (), scope, 0, story.state, NO_DECISION)
        story.writer.returned(call, "done", 0)
        paths.append(story.end())
    assert first(capsys, *paths)["kind"] == "scope"
    assert run(["trace", "diff", *map(str, paths), "--no-scopes"]) == 0
