"""Errors of a user's Python are reported in a sentence with their location, by a check and in a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from checked_libraries import excerpt
from row_library import PYTHON, written

from ntp_dsl.cli.app import run
from ntp_dsl.dynamic.check import check_dynamically
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic
from ntp_dsl.policies.expert import call
from ntp_dsl.policies.scripted import check_numbers
from ntp_dsl.semantics.value_checks import OutOfRange
from ntp_dsl.tasks.goal_samplers import NoGoal
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.catalogue import WORLDS, make_world
from ntp_dsl.worlds.protocol import ACHIEVED, Failure, Outcome

RELEASED = '    return world.call("release", ())'
CALLED = '    return [call("append", *link) for link in links if not world.beside(*link)]'
NEAR = "    return distance(observation, o, after, gap) < 0.07"
ROWS = "    return list(zip(items, [marks[0], *items], gaps, strict=False))"
SET_DOWN, LINE_UP, IN_THE_WAY = "set_down", "line_up", "in_the_way"
LINK = "record Link(item: Movable, after: Place, gap: length)"
GOAL = "rows(marks, blocks, length=2..3) -> list[Link] by python"
OUTCOME, TRUTH = "expected an Outcome: return that of world.call", "expected True or False"
CALLS = "expected call(...), several of them in a list, or None"
ERRORS = {
    # error: original text, replacement, excerpt at its location, code, and message
    "a skill that returns nothing": (RELEASED, RELEASED.replace("return ", ""), SET_DOWN, "E607",
        f"'set_down' answered None; {OUTCOME}"),
    "a skill that returns a bool": (RELEASED, f"{RELEASED}.achieved", SET_DOWN, "E607",
        f"'set_down' answered True; {OUTCOME}"),
    "a skill that returns a text": (RELEASED, "    return 'done'", SET_DOWN, "E607",
        f"'set_down' answered 'done'; {OUTCOME}"),
    "a skill that calls an api by a wrong name": (RELEASED, RELEASED.replace("release", "relase"), SET_DOWN,
        "E607", "'set_down' failed: no api is called 'relase'; did you mean 'release'?"),
    "a skill that calls an api with a text": (RELEASED, RELEASED.replace('"release", ()', '"move_to", item'),
        SET_DOWN, "E607", "write the arguments as a tuple"),
    "a skill that calls an api with too much": (RELEASED, RELEASED.replace("()", "(item,)"), SET_DOWN,
        "E607", "it is declared as release()"),
    "a skill that calls an api with a number": (RELEASED, RELEASED.replace('release", ()', 'grasp", (gap,)'),
        SET_DOWN, "E607", "expected the name of an object in the scene"),
    "an expert that offers a tuple": (CALLED, CALLED.replace('call("append", *link)', '("append", *link)'),
        LINE_UP, "E607", f"{CALLS}; write: call('append', 'block_"),
    "an expert that returns a tuple": (CALLED, "    return 'append', *links[0]", LINE_UP, "E607",
        f"{CALLS}; write: call('append', 'block_"),
    "an expert that returns a text": (CALLED, "    return 'append'", LINE_UP, "E607",
        f"'line_up' answered 'append'; {CALLS}"),
    "an expert that offers nothing among calls": (CALLED, "    return [call('append', *links[0]), None]",
        LINE_UP, "E607", f"{CALLS}; not None among them"),
    "an expert that asks for an unknown type": (CALLED, f"    world.objects('Blok')\n{CALLED}", LINE_UP,
        "E607", "'line_up' failed: no type is called 'Blok'; did you mean 'Block'?"),
    "an expert that asks for an unknown predicate": (CALLED, CALLED.replace("beside", "besides"), LINE_UP,
        "E607", "no predicate is called 'besides'; did you mean 'beside'?"),
    "an expert that calls with a mark": (CALLED, CALLED.replace("*link)", "'mark_0', *link[1:])"),
        LINE_UP, "E607", "'item: Movable' is 'mark_0'; expected a Movable, and 'mark_0' is a Mark"),
    "a predicate that is a number": (NEAR, NEAR.replace(" < 0.07", ""), IN_THE_WAY, "E607", TRUTH),
    "a predicate that is a text": (NEAR, "    return 'no'", IN_THE_WAY, "E607",
        f"'in_the_way' answered 'no'; {TRUTH}"),
    "a predicate that says nothing": (NEAR, "    pass", IN_THE_WAY, "E607",
        f"'in_the_way' answered None; {TRUTH}"),
    "a sampler that returns nothing": (ROWS, ROWS.replace("return ", ""), GOAL, "E608",
        "'rows' answered None; expected a list of rows"),
    "a sampler that returns a number": (ROWS, "    return 2", GOAL, "E608",
        "'rows' answered 2; expected a list"),
    "a sampler that returns one row": (ROWS, "    return items[0], marks[0], 0.1", GOAL, "E608",
        "yields rows of (item, after, gap); found 'block_"),
    "a sampler that draws another type": (ROWS, "    return [(marks[0], items[0], 0.1)] * length",
        GOAL, "E608", "drew 'mark_0' for 'item: Movable'; expected a Movable, and 'mark_0' is a Mark"),
    "a sampler that draws less than it is asked for": (ROWS, f"{ROWS}[:1]", GOAL, "E608",
        "and drew 1 elements; ask for less"),
    "a number out of the range of an api": ("[0.09, 0.11, 0.13]", "[9, 11, 13]", "set_down(item, after, gap)",
        "E607", "and takes 0.08 .. 0.14 [SI units]; draw or calculate a number within, or declare a wider"),
    "a number out of the range of a field": (LINK, LINK.replace(")", " in 0 .. 10 cm)"), GOAL, "E608",
        "for 'gap: length'; expected 0 .. 0.1"),
}  # fmt: skip
EVAL = ["--expert", "--episodes", "6"]


def checked(path: Path) -> list[Diagnostic]:
    return check_dynamically(load_with_python(path), path)


def test_the_library_is_sound_as_it_is(tmp_path: Path) -> None:
    path = written(tmp_path)
    assert [str(each) for each in checked(path)] == []
    assert run(["eval", str(path), "in_a_row", *EVAL]) == 0


@pytest.mark.parametrize(
    "old, new",
    [
        ('link["gap"])', '__import__("numpy").float32(link["gap"]))'),
        ("return low and distance(", "return __import__('numpy').bool_(low) and distance("),
        (
            "@predicate\ndef in_the_way(observation, o,",
            "def in_the_way(far, observation, o,",
        ),
    ],
)
def test_numpy_values_and_other_callables_are_accepted(tmp_path: Path, old: str, new: str) -> None:
    path = written(tmp_path, old, new)
    if "far" in new:
        python = path.with_suffix(".py")
        partial = '\n\nways = predicate("in_the_way")(__import__("functools").partial(in_the_way, 0.07))\n'
        python.write_text(python.read_text().replace("gap) < 0.07", "gap) < far") + partial)
    assert run(["eval", str(path), "in_a_row", *EVAL]) == 0


@pytest.mark.parametrize("case", ERRORS)
def test_an_error_is_reported_by_a_check_at_its_location(tmp_path: Path, case: str) -> None:
    old, new, place, code, message = ERRORS[case]
    path = written(tmp_path, old, new)
    error, *others = [each for each in checked(path) if each.severity == "error"]
    assert error.code == code and message in error.message and excerpt(path, error) == place
    assert {each.code for each in others} <= {code}
    assert f"{path.stem}.py:" in error.message or f"{path.name}:" in error.message


@pytest.mark.parametrize("case", ERRORS)
def test_an_error_is_a_sentence_in_a_run(
    tmp_path: Path, case: str, capsys: pytest.CaptureFixture[str]
) -> None:
    old, new, _, _, message = ERRORS[case]
    path = written(tmp_path, old, new)
    assert run(["eval", str(path), "in_a_row", *EVAL]) == 2
    output = capsys.readouterr().err
    assert message in " ".join(output.split()) and "Traceback" not in output


@pytest.mark.parametrize("name", WORLDS)
def test_a_number_out_of_its_range_is_an_error_of_the_expert_and_refused_of_others(
    tmp_path: Path, name: str
) -> None:
    """A learned program may err in a number: its call fails, and the run goes on."""
    registry = load_with_python(written(tmp_path))
    world = make_world(name, registry)
    world.reset(draw(registry, find_task(registry, "in_a_row"), rng()).nominal_start(rng()), 0)
    outcome = world.call("set_down", ("block_0", "mark_0", 9.0))
    assert outcome.failure is Failure.NOT_READY and outcome.evidence == {"out of range": ["gap = 9.0"]}
    with pytest.raises(OutOfRange, match=r"gap = 9, and takes 0.08 \.\. 0.14"):
        check_numbers(registry, call("set_down", "block_0", "mark_0", 9.0))
    check_numbers(registry, call("set_down", "block_0", "mark_0", 0.14 + 1e-9))


def rng() -> np.random.Generator:
    return np.random.default_rng(3)


def test_a_sampler_may_draw_more_than_its_length_and_not_less(tmp_path: Path) -> None:
    registry = load_with_python("table_cleanup")
    task = find_task(registry, "table_cleanup")
    assert len(draw(registry, task, rng(), {"length": (2, 2)}).goal) > 2  # forks, and all bowls
    with pytest.raises(NoGoal, match="was asked for length=40, and drew"):
        draw(registry, task, rng(), {"length": (40, 40)})


def test_a_numpy_bool_is_accepted(tmp_path: Path) -> None:
    answer = "    import numpy\n    return numpy.bool_(distance(observation, o, after, gap) < 0.07)"
    assert checked(written(tmp_path, NEAR, answer)) == []


def test_a_list_in_a_call_is_a_tuple() -> None:
    assert call("stack", ["a", "b"]) == call("stack", ("a", "b"))


def test_an_outcome_is_true_where_it_achieved_something() -> None:
    assert ACHIEVED and not Outcome(False, Failure.NO_PATH)
    assert "if not (over := world.move_over" in PYTHON


def test_wrong_subprograms_of_a_recording_may_have_numbers_out_of_range(tmp_path: Path) -> None:
    path = written(tmp_path)
    assert run(["record", str(path), "in_a_row", "-n", "8", "--out", str(tmp_path / "data")]) == 0
