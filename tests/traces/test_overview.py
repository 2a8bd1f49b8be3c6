"""How an episode ended names its cause: planted in a library, a demonstration, the looks or the hand."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from msgspec.structs import replace as with_fields

from ntp_dsl.cli.app import run
from ntp_dsl.semantics.observation import Argument, Record
from ntp_dsl.traces.aftermath import never_made_good
from ntp_dsl.traces.comparison.divergence import compare
from ntp_dsl.traces.explanation import explanation, interesting
from ntp_dsl.traces.overview import overview
from ntp_dsl.traces.phrases import format_call
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import Attribution, CallOutcome, Ending
from ntp_dsl.traces.trace import Trace

STACK = """library planted
use tabletop

{api}
program stack(goal: list[Placement]):
    achieves all on(p.item, p.support) for p in goal
    for p in goal:
        {call}

task planted:
    scene:   blocks: 4 Block on table
    goal:    towers(blocks, placements=2..2, height=3)
    run:     stack(goal)
    success: all on(p.item, p.support) for p in goal
"""
LIE = """api praise(target: Object) by move_to
    requires present(target) and reachable(target)
    achieves holding(target)

program bring(item: Movable, support: Place):
    requires present(item) and reachable(item) and present(support) and reachable(support)
    achieves on(item, support)
    clear(support)
    clear(item)
    praise(item)
    place(item, support)
"""
LOOP = "        for s in Shelf:"
ASIDE = f"""type Shelf is Place

program aside(item: Movable):
    achieves clear(item)
    for o in Movable if covers(o, item):
{LOOP}
            pick_and_place(o, s)
"""


def traced(folder: Path, api: str, call: str, *words: str) -> Trace:
    """Write a library, evaluate an episode of it, and return the trace that is kept."""
    library = folder / "planted.ntp"
    library.write_text(STACK.format(api=api, call=call), encoding="utf-8")
    out = folder / "out"
    assert run(["eval", str(library), "planted", "-n", "1", "--seed", "2", "--out", str(out), *words]) == 0
    return read_trace(out / "episode_00000.trace.jsonl")


def test_a_demonstration_that_fails_leaves_its_trace_and_its_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    trace = traced(tmp_path, "", "pick(p.item)")  # and never puts it down
    said = capsys.readouterr().out
    assert "failures         decision 1" in said and "does not hold; " in said
    assert trace.end is not None and trace.end.success is False
    assert trace.end.attributed_to is Attribution.DECISION
    assert trace.end.verdict.split(";")[0] in said and trace.header.sources
    assert overview(trace)[0].startswith("The episode by the demonstration policy failed")


def test_a_statement_that_cannot_help_is_named(tmp_path: Path) -> None:
    trace = traced(tmp_path, "", "clear(p.item)")
    assert trace.end is not None and trace.end.ending is not Ending.DONE
    reasons = [call.return_decision.reason for call in trace.calls if call.return_decision]
    assert any(reason.startswith("no statement achieves on(block_") for reason in reasons)


def test_a_primitive_that_does_not_do_what_it_says_is_named(tmp_path: Path) -> None:
    trace = traced(tmp_path, LIE, "bring(p.item, p.support)")
    broken = [call for call in trace.calls if call.execution.unmet]
    assert broken and {call.name for call in broken} == {"praise"}
    assert all(call.execution.unmet == (f"holding({call.arguments[0]})",) for call in broken)
    told = " ".join(overview(trace))
    assert f"praise reported success {len(broken)} time" in told and f"after {len(broken)} of them" in told


def test_primitives_that_do_what_they_say_are_not(tmp_path: Path) -> None:
    trace = traced(tmp_path, "", "pick_and_place(p.item, p.support)", "--slips", ".5")
    assert not any(call.execution.unmet for call in trace.calls)
    assert not any("reported success" in each for each in overview(trace))


def test_noise_that_misleads_is_named_and_a_divergence_is_attributed_to_it(tmp_path: Path) -> None:
    call = "pick_and_place(p.item, p.support)"
    noisy = traced(tmp_path, "", call, "--noise", ".03", "--slips", ".5")
    told = " ".join(overview(noisy))
    assert "noise 30 mm" in told and "decisions rest on a fact seen wrongly, most often " in told
    exact = traced(tmp_path, "", call, "--expert", "--slips", ".5")
    causes = {each.attributed_to for each in compare(exact, noisy, scopes=False).divergences}
    assert Attribution.NOISE in causes and Attribution.PHYSICS not in causes


def test_a_demonstration_of_something_else_is_named(tmp_path: Path) -> None:
    trace = traced(tmp_path, "", "pick_and_place(p.item, p.support)")
    goal = trace.header.goal
    other = Record(goal[0].type, tuple((name, "block_9") for name, _ in goal[0].fields))
    trace.header = with_fields(trace.header, goal=(goal[0], other))
    assert "Of its goal, (block_9, block_9) was not read from the demonstration" in " ".join(overview(trace))


def test_a_number_that_was_read_with_a_small_error_was_read(tmp_path: Path) -> None:
    trace = traced(tmp_path, "", "pick_and_place(p.item, p.support)")
    for off, told in ((0.004, False), (0.02, True)):
        near = with_number(trace.header.goal, 0.11)
        for call in trace.calls:
            read = call.decision.read
            if read is not None:
                lists = (
                    with_fields(read.lists[0], elements=with_number(read.lists[0].elements, 0.11 + off)),
                )
                call.decision = with_fields(call.decision, read=with_fields(read, lists=lists))
        trace.header = with_fields(trace.header, goal=near)
        assert ("not read from the demonstration" in " ".join(overview(trace))) is told


def with_number(elements: Sequence[Argument], number: float) -> tuple[Record, ...]:
    """Return records with a last field that is a number."""
    records = [each for each in elements if isinstance(each, Record)]
    return tuple(Record(each.type, (*each.fields[:2], ("gap", number))) for each in records)


def test_the_last_primitive_that_was_not_made_good_is_explained(tmp_path: Path) -> None:
    trace = traced(tmp_path, LIE, "bring(p.item, p.support)")
    asked = interesting(trace)
    assert asked is not None and asked.name == "praise" and asked.execution.unmet
    assert "Seen afterwards: the gripper at " in " ".join(explanation(trace, asked))


def test_a_drop_that_was_made_good_is_not(tmp_path: Path) -> None:
    trace = traced(tmp_path, "", "pick_and_place(p.item, p.support)", "--slips", ".9")
    assert trace.end is not None and trace.end.success
    assert any(call.execution.disturbances for call in trace.calls)
    assert never_made_good(trace) == [] and "never made good" not in " ".join(overview(trace))


def test_a_loop_over_a_type_without_objects_is_named(tmp_path: Path) -> None:
    trace = traced(tmp_path, ASIDE, "aside(p.item)")
    line = next(iter(trace.header.sources.values())).split("\n").index(LOOP) + 1
    said = [each for each in overview(trace) if each.startswith("No object of the scene is a ")]
    assert said == [f"No object of the scene is a Shelf, so that line {line} of aside calls nothing."]


LIFT = """program bring(item: Movable, support: Place):
    requires present(item) and reachable(item) and present(support) and reachable(support)
    achieves on(item, support)
    pick(item)
"""


def test_where_nothing_went_wrong_the_program_that_got_stuck_is_explained(tmp_path: Path) -> None:
    trace = traced(tmp_path, LIFT, "bring(p.item, p.support)")
    asked = interesting(trace)
    assert asked is not None and asked.name == "bring" and trace.children(asked.id)
    told = " ".join(explanation(trace, asked))
    assert "Its reason: no statement achieves on(" in told and "pick(" in told


def test_a_return_that_the_declaration_would_not_make_is_told(tmp_path: Path) -> None:
    trace = traced(tmp_path, "", "pick_and_place(p.item, p.support)")
    call = next(each for each in trace.calls if each.name == "pick")
    made = trace.children(call.id)[0]
    sentence = f"By the declaration it would have called {format_call(made)}: the network decided otherwise."
    call.return_decision = made.decision
    assert sentence not in " ".join(explanation(trace, call))
    call.outcome = CallOutcome.UNFINISHED
    assert sentence in " ".join(explanation(trace, call))
