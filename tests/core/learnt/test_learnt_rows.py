"""A program's row is learnt from traces of its expert, and nothing else changes."""

from __future__ import annotations

import json
from pathlib import Path
from shutil import copytree

import pytest

from ntp_dsl.api import demonstrate, draw
from ntp_dsl.api import run as run_task
from ntp_dsl.cli.app import run
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.core.dispatch.dispatcher import Situation
from ntp_dsl.core.dispatch.learned import LearnedDispatcher
from ntp_dsl.core.learnt.learnt_rows import SUFFIX, read_row, rows_beside
from ntp_dsl.core.models import open_model
from ntp_dsl.core.one_core import load_one_core, shipped_core
from ntp_dsl.core.perception.perceived import Believed
from ntp_dsl.core.perception.steadied import steadied
from ntp_dsl.policies.expert import Expert
from ntp_dsl.user_code.loading import load_with_python

NUMBER = """library counting
use tabletop

api wave(times: number in 0 .. 9)
    requires empty(gripper)
    achieves greeted()
predicate greeted() by state

program greet() by python:
    achieves greeted()
    calls wave

task counting:
    scene:   blocks: 2 Block on table
    run:     greet()
    success: greeted()
"""
WAVING = """from ntp_dsl.authoring import call, expert


@expert
def greet(world):
    return call("wave", float(len(world.objects("Block"))))
"""


def copied(name: str, to: Path) -> Path:
    """Return a copy of an example without the rows that ship with it."""
    folder = copytree(examples_folder() / name, to / name)
    for row in folder.glob(f"*{SUFFIX}"):
        row.unlink()
    return folder


def edited(file: str, before: str, after: str, to: Path) -> Path:
    """Return a copy of the docks, with its row, in which a text of a file is another."""
    folder = copytree(examples_folder() / "docks", to / "docks")
    text = (folder / file).read_text(encoding="utf-8")
    assert before in text
    (folder / file).write_text(text.replace(before, after, 1), encoding="utf-8")
    return folder


def recorded(library: Path, task: str, count: int) -> Path:
    """Return a folder with traces of a library's expert."""
    out = library.parent / "data"
    assert run(["record", str(library), task, "-n", str(count), "--seed", "40", "--out", str(out)]) == 0
    return out


def trained(library: Path, program: str, data: Path) -> int:
    return run(["train", str(library), "--program", program, "--data", str(data)])


def test_a_rule_that_only_python_says_is_learnt_and_its_function_is_not_called(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    library = copied("docks", tmp_path)
    assert trained(library, "relieve", recorded(library, "docks", 25)) == 0
    told = capsys.readouterr().err
    assert (
        "unload(dock, van)" in told
        and "large urgency(dock), small distance of dock from van come first" in told
    )
    assert (
        run(["check", str(library)]) == 0 and "decided by its row, learnt from 25" in capsys.readouterr().out
    )
    out = tmp_path / "out"
    assert run(["eval", str(library), "docks", "-n", "5", "--seed", "3", "--json", "--out", str(out)]) == 0
    assert json.loads(capsys.readouterr().out)["success"] == 1.0
    lines = "".join(each.read_text(encoding="utf-8") for each in out.glob("*.trace.jsonl"))
    assert '"scripted":true' not in lines


def test_of_what_a_declaration_is_silent_five_episodes_tell(tmp_path: Path) -> None:
    """A body in place of the function sees to the dishes in the order of the scene."""
    full = copied("dishes", tmp_path)
    data = recorded(full, "dishes", 5)
    silent = copied("dishes", tmp_path / "silent") / "dishes.ntp"
    text = silent.read_text(encoding="utf-8").replace(
        "wash_up(tub: Tub, rack: Rack) by python:", "wash_up(tub: Tub, rack: Rack):"
    )
    silent.write_text(
        text.replace("    calls see_to\n", "    for d in Dish: see_to(d, tub, rack)\n"), encoding="utf-8"
    )

    def successes() -> list[bool]:
        found = []
        for seed in range(4):
            task = draw(load_with_python(full), "dishes", seed)
            model = open_model(shipped_core(), load_with_python(silent), "wash_up")
            found.append(bool(run_task(task, model.shown(demonstrate(task).demonstration)).success))
        return found

    assert not any(successes())
    assert trained(silent, "wash_up", data) == 0
    row = read_row(silent.parent / f"wash_up{SUFFIX}")
    assert row.calls == () and [str(each.column) for each in row.preference.terms] == ["grease(d)"]
    assert all(successes())


def test_decisions_of_other_programs_are_unchanged() -> None:
    registry = load_with_python("docks")
    expert, core = Expert(registry), load_one_core(shipped_core())
    task = draw(registry, "docks", 2)
    states = steadied(demonstrate(task).demonstration)
    rows = rows_beside(registry)
    preferences, learnt = rows.preferences, rows.applied(registry)
    assert preferences.keys() == {"relieve"} and preferences["relieve"].terms
    for frame in range(0, len(states.closed), 9):
        state = Believed(registry, states.observation(frame), {})
        asked = [Situation("unload", (f"dock_{number}", "van"), state) for number in range(8)]
        both = LearnedDispatcher(Expert(learnt), core.dispatch, preferences)
        assert both.dispatch([Situation("relieve", ("van",), state), *asked])[1:] == both.dispatch(asked)
        with_row = LearnedDispatcher(expert, core.dispatch, preferences).dispatch(asked)
        assert with_row == LearnedDispatcher(expert, core.dispatch).dispatch(asked)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("achieves not full(dock)", "achieves not full(dock) and empty(gripper)"),
        ("some covers(p, d) for p in Parcel", "some on(p, d) for p in Parcel"),
        ("predicate urgency(d: Dock) -> number", "predicate urgency(d: Place) -> number"),
    ],
)
def test_a_row_of_another_declaration_is_refused(
    before: str, after: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    library = edited("docks.ntp", before, after, tmp_path)
    for command in (["eval", str(library), "docks", "-n", "1"], ["check", str(library)]):
        assert run(command) == 2
        told = capsys.readouterr().err
        assert "was learnt of another declaration of 'relieve', or of what it calls" in told


def test_what_a_preference_does_not_look_at_does_not_stop_a_run(tmp_path: Path) -> None:
    """No scene gives a weight; the row needs none."""
    more = "predicate weight(m: Place) -> number\npredicate heavy(m: Place): weight(m) > 2\n\n"
    library = edited("docks.ntp", "program relieve", f"{more}program relieve", tmp_path)
    assert run(["eval", str(library), "docks", "-n", "1"]) == 0


def test_what_is_no_row_is_neither_read_nor_replaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    library = copied("docks", tmp_path)
    data = recorded(library, "docks", 1)
    row = library / f"relieve{SUFFIX}"
    row.write_text("mine", encoding="utf-8")
    assert run(["eval", str(library), "docks", "-n", "1"]) == 2
    assert "expected a row of `ntp train --program`" in capsys.readouterr().err
    assert trained(library, "relieve", data) == 2
    assert "nothing is replaced" in capsys.readouterr().err and row.read_text(encoding="utf-8") == "mine"


def test_the_rule_has_no_rows(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["eval", "docks", "docks", "-n", "1", "--dispatch", "rule"]) == 2
    assert "the rule knows nothing of the rows learnt of relieve" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--program", "reliev"], "has no program 'reliev'; did you mean 'relieve'?"),
        (["--program", "unload", "--iterations", "5"], "--program goes without --iterations"),
        (["--program", "unload"], "no trace of an expert has a call of 'unload'"),
    ],
)
def test_what_cannot_be_learnt_is_said(
    words: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = recorded(copied("dishes", tmp_path), "dishes", 1)
    assert run(["train", str(copied("docks", tmp_path)), "--data", str(data), *words]) == 2
    assert message in capsys.readouterr().err


def test_a_number_that_a_function_computes_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "counting.ntp").write_text(NUMBER, encoding="utf-8")
    (tmp_path / "counting.py").write_text(WAVING, encoding="utf-8")
    library = tmp_path / "counting.ntp"
    assert trained(library, "greet", recorded(library, "counting", 1)) == 2
    assert (
        "the argument 'times' of wave, such as 2.0, is no parameter of the program" in capsys.readouterr().err
    )


def test_the_row_of_what_ships_is_written_only_where_one_says(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = recorded(copied("docks", tmp_path), "docks", 1)
    assert trained(examples_folder() / "docks", "relieve", data) == 2
    assert "ships with the package" in capsys.readouterr().err
    out = tmp_path / "mine.json"
    words = ["train", "docks", "--program", "relieve", "--data", str(data), "--out", str(out)]
    assert run(words) == 0 and read_row(out).decisions == 3


def test_traces_of_another_declaration_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    library = copied("docks", tmp_path)
    data = recorded(library, "docks", 1)
    text = (library / "docks.ntp").read_text(encoding="utf-8")
    turned = text.replace("unload(dock: Dock, van: Van)", "unload(van: Van, dock: Dock)")
    (library / "docks.ntp").write_text(turned, encoding="utf-8")
    assert trained(library, "relieve", data) == 2
    assert (
        "the traces are of another declaration: in one of them 'unload' is called" in capsys.readouterr().err
    )


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ('"callee": "unload"', '"callee": "put_in"'),
        ('"type": "Dock"', '"type": "Nothing"'),
        ('"type": "Dock"', '"name": "bogus"'),
        ('"name": "van"', '"name": "van", "field": "bogus"'),
        ('"callee": "unload"', '"callee": "nowhere"'),
    ],
)
def test_a_row_with_calls_that_the_program_cannot_make_is_refused(
    before: str, after: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    library = edited(f"relieve{SUFFIX}", before, after, tmp_path)
    assert run(["eval", str(library), "docks", "-n", "1"]) == 2
    assert "has calls that 'relieve' cannot make: train it anew" in capsys.readouterr().err


def test_a_row_of_another_function_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    library = edited("docks.py", "reverse=True", "reverse=False", tmp_path)
    assert run(["eval", str(library), "docks", "-n", "1"]) == 2
    assert "was learnt of another text of the function 'relieve'" in capsys.readouterr().err


def test_the_row_of_another_program_is_not_replaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    library = copied("docks", tmp_path)
    out = tmp_path / "wash_up.json"
    out.write_bytes((examples_folder() / "dishes" / f"wash_up{SUFFIX}").read_bytes())
    words = ["--program", "relieve", "--data", str(recorded(library, "docks", 1)), "--out", str(out)]
    assert run(["train", str(library), *words]) == 2
    assert "is the row of 'wash_up': nothing is replaced" in capsys.readouterr().err


TWO_WAYS = """library baskets
use containers

type Fruit is Movable
type Basket is Place

predicate ripe(f: Fruit) -> number
predicate away(f: Fruit): some in(f, b) for b in Basket

program sort_out(good: Basket, rest: Basket) by python:
    requires present(good) and hollow(good) and reachable(good) and present(rest) and reachable(rest)
    achieves all away(f) for f in Fruit
    calls keep, put_in

program keep(item: Fruit, container: Basket):
    requires (
        present(item) and reachable(item)
        and hollow(container) and present(container) and reachable(container)
    )
    achieves in(item, container)
    put_in(item, container)

task baskets:
    scene:
        good:   Basket on table with bin(20 cm, 20 cm, 6 cm), at(45 cm, 22 cm)
        rest:   Basket on table with bin(20 cm, 20 cm, 6 cm), at(45 cm, -22 cm)
        fruits: 5 Fruit on table with cube(4 cm), ripe(4, 1, 5, 2, 3)
    run:     sort_out(good, rest)
    success: all away(f) for f in Fruit
"""
SORTING = """from ntp_dsl.authoring import call, expert, first


@expert
def sort_out(world, good, rest):
    fruits = sorted((each for each in world.objects("Fruit") if not world.away(each)), key=world.ripe)
    return first(
        call("keep", each, good) if world.ripe(each) > 2 else call("put_in", each, rest) for each in fruits
    )
"""


def test_which_of_two_callees_is_learnt_though_they_name_alike_what_they_take(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "baskets.ntp").write_text(TWO_WAYS, encoding="utf-8")
    (tmp_path / "baskets.py").write_text(SORTING, encoding="utf-8")
    library = tmp_path / "baskets.ntp"
    assert trained(library, "sort_out", recorded(library, "baskets", 20)) == 0
    told = capsys.readouterr().err
    assert "keep(fruit, good)" in told and "put_in(fruit, rest)" in told
    assert " of keep" in told or " of put_in" in told
    row = read_row(tmp_path / f"sort_out{SUFFIX}")
    assert row.foreseen > 0.95
