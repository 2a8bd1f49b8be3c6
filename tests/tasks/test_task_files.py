"""Tasks from files: ours and the authors', and a sentence for everything else."""

from __future__ import annotations

import json
from copy import deepcopy
from pathlib import Path
from typing import Any

import msgspec
import pytest

from ntp_dsl.cli.app import run
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import SceneObject
from ntp_dsl.tasks.task_files import TaskFileEntry, as_file, read_tasks, write_tasks
from ntp_dsl.worlds.arm import ArmWorld
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.protocol import Failure, Scene

AUTHORS: dict[str, Any] = {
    "name": "stacking",
    "scene": {
        "objects": [
            {"name": f"cube_{n}", "filename": f"cubes/cube_{n}.urdf", "scale": [0.05, 0.05, 0.05]}
            for n in range(8)
        ],
    },
    "tasks": [
        {
            "id": "stack_1",
            "name": "stack",
            "goals": [
                {"name": "pick_place", "src": "cube_6", "target": "cube_5"},
                {"name": "pick_place", "src": "cube_4", "target": "cube_6"},
            ],
            "end_constraints": [{"type": "on_top", "src": "cube_6", "target": "cube_5"}],
        }
    ],
}
CUBES = tuple(SceneObject(f"cube_{n}", "Block", (0.05, 0.05, 0.05)) for n in range(8))
GOAL = ({"item": "cube_6", "support": "cube_5"}, {"item": "cube_4", "support": "cube_6"})
ENTRY = TaskFileEntry("stack_1", CUBES, GOAL)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "tasks.json"


def test_the_authors_tasks_keep_their_order_and_their_cubes(file: Path) -> None:
    file.write_text(json.dumps(AUTHORS))
    assert read_tasks(file) == [ENTRY]
    assert ENTRY.names == tuple(f"cube_{n}" for n in range(8))


def test_what_is_written_is_read_back(file: Path) -> None:
    write_tasks([ENTRY], file)
    assert read_tasks(file) == [ENTRY]
    assert list(file.parent.iterdir()) == [file]


def test_the_command_writes_what_it_would_print(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file.write_text(json.dumps(AUTHORS))
    out = tmp_path / "out.json"
    assert run(["import-vat", str(file)]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert run(["import-vat", str(file), "--out", str(out)]) == 0
    assert "1 task written" in capsys.readouterr().err
    assert json.loads(out.read_text()) == printed == OURS
    assert run(["import-vat", str(out), "--out", str(out)]) == 2
    assert "would be overwritten" in capsys.readouterr().err


def changed(document: dict[str, Any], *path: str | int, value: Any) -> dict[str, Any]:
    copy = deepcopy(document)
    inner: Any = copy
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    return copy


OURS = msgspec.json.decode(msgspec.json.encode(as_file([ENTRY])))
FOREIGN = {
    "another scene": (changed(AUTHORS, "name", value="sorting"), "'stacking', found \"sorting\""),
    "another action": (
        changed(AUTHORS, "tasks", 0, "goals", 1, "name", value="push"),
        r"'push' - at `\$.tasks\[0\].goals\[1\].name`",
    ),
    "another kind of object": (
        changed(AUTHORS, "scene", "objects", 3, "filename", value="forks/fork_1.urdf"),
        r"matching regex '\^cubes/' - at `\$.scene.objects\[3\].filename`",
    ),
    "no tasks": (changed(AUTHORS, "tasks", value=[]), r"length >= 1 - at `\$.tasks`"),
    "tasks of another kind": (changed(AUTHORS, "tasks", value="all"), r"`array`, got `str` - at `\$.tasks`"),
    "a task of another kind": (
        changed(AUTHORS, "tasks", 0, value=3),
        r"`object`, got `int` - at `\$.tasks\[0\]`",
    ),
    "no scene": (changed(AUTHORS, "scene", value=None), r"`object`, got `null` - at `\$.scene`"),
    "another version": (changed(OURS, "version", value=3), "version 2, found 3"),
    "a truth for a version": (changed(OURS, "version", value=True), "version 2, found true"),
    "an item on itself": (
        changed(OURS, "tasks", 0, "goal", 0, "support", value="cube_6"),
        "different objects in one row",
    ),
    "a name twice": (changed(OURS, "tasks", 0, "objects", 0, "name", value="cube_1"), "one name twice"),
    "a flat object": (
        changed(OURS, "tasks", 0, "objects", 0, "size", value=[0.05, 0.05, 0]),
        "three positive sizes of 'cube_0'",
    ),
    "a size of words": (
        changed(OURS, "tasks", 0, "objects", 0, "size", value=["a", True, None]),
        r"at `\$.tasks\[0\].objects\[0\].size\[0\]`",
    ),
    "a number for a name": (
        changed(OURS, "tasks", 0, "id", value=7),
        r"`str`, got `int` - at `\$.tasks\[0\].id`",
    ),
    "a list": ([AUTHORS], "expected a file of tasks"),
    "another document": ({"format": "geojson", "features": []}, "found an object of 'format'"),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_what_is_not_a_file_of_tasks_is_told_what_was_expected(file: Path, name: str) -> None:
    document, said = FOREIGN[name]
    file.write_text(json.dumps(document))
    with pytest.raises(NtpError, match=said) as caught:
        read_tasks(file)
    assert str(caught.value).startswith(f"{file}: ") and "\n" not in str(caught.value)


def test_a_file_that_was_cut_off_is_told_so(file: Path) -> None:
    whole = json.dumps(AUTHORS)
    for length in range(0, len(whole), 25):
        file.write_text(whole[:length])
        with pytest.raises(NtpError, match="in JSON, found something else"):
            read_tasks(file)


@pytest.mark.parametrize("content", [b"\xff\xfe", b"\x89PNG", b"[" * 100_000])
def test_what_is_no_text_is_told_so(file: Path, content: bytes) -> None:
    file.write_bytes(content)
    with pytest.raises(NtpError, match="expected a file of tasks"):
        read_tasks(file)


@pytest.mark.authors_data
@pytest.mark.parametrize("name, count", [("stack_train_1000.json", 1000), ("stack_unseen_500.json", 500)])
def test_the_authors_own_files_are_read(authors_data: Path, name: str, count: int) -> None:
    entries = read_tasks(authors_data / name)
    assert len(entries) == count and all(len(entry.objects) == 8 for entry in entries)
    assert {len(entry.goal) for entry in entries} <= set(range(1, 8))


def test_objects_of_a_file_have_any_size_and_shape(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sizes = {"slab": (0.06, 0.06, 0.03), "cube": (0.05, 0.05, 0.05), "stub": (0.03, 0.03, 0.04)}
    objects = [{"name": name, "type": "Block", "size": size} for name, size in sizes.items()]
    objects.append({"name": "can", "type": "Block", "size": (0.04, 0.04, 0.05), "shape": "cylinder"})
    goal = [{"item": "cube", "support": "slab"}, {"support": "cube", "item": "stub"}]
    file = tmp_path / "mixed.json"
    tasks = [{"id": "one", "objects": objects, "goal": goal}]
    file.write_text(json.dumps({"format": "ntp-tasks", "version": 2, "tasks": tasks}))
    words = ["eval", "block_stacking", "block_stacking", "--expert", "--episodes", "1", "--json"]
    assert run([*words, "--tasks", str(file)]) == 0
    assert json.loads(capsys.readouterr().out)["success"] == 1.0


BESIDE = Path(__file__).parents[1] / "evaluation" / "domains" / "beside_the_mark"


@pytest.mark.parametrize(
    "row, said",
    [
        ({"peg": "p_0", "mark": "m_0", "side": "left", "distance": 0.12}, ""),
        ({"peg": "p_0", "mark": "m_0"}, "expected Spot with the fields peg, mark, side, distance, found"),
        ({"peg": "p_9", "mark": "m_0", "side": "left", "distance": 0.12}, "found 'p_9'"),
    ],
)
def test_goals_of_a_file_are_records_of_the_tasks_own_kind(
    row: dict[str, object], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    objects = [
        {"name": "m_0", "type": "Mark", "size": (0.06, 0.06, 0.005), "fixed": True},
        {"name": "tray", "type": "Tray", "size": (0.2, 0.14, 0.01), "fixed": True},
        {"name": "p_0", "type": "Peg", "size": (0.03, 0.03, 0.06)},
    ]
    file = tmp_path / "spots.json"
    tasks = [{"id": "one", "objects": objects, "goal": [row]}]
    file.write_text(json.dumps({"format": "ntp-tasks", "version": 2, "tasks": tasks}))
    words = ["eval", str(BESIDE), "beside_the_mark", "--expert", "--episodes", "1", "--json"]
    assert run([*words, "--tasks", str(file)]) == (2 if said else 0)
    told = capsys.readouterr()
    if said:
        assert said in told.err and told.err.startswith(f"{file}: one: ")
    else:
        assert json.loads(told.out)["success"] == 1.0


def _of_blocks(file: Path, goal: list[dict[str, object]], **block_0: object) -> Path:
    """Write a file of one task over three blocks, the first with other properties."""
    size = [0.05, 0.05, 0.05]
    blocks: list[dict[str, object]] = [
        {"name": f"block_{n}", "type": "Block", "size": size} for n in range(3)
    ]
    blocks[0] |= block_0
    tasks = [{"id": "one", "objects": blocks, "goal": goal}]
    file.write_text(json.dumps({"format": "ntp-tasks", "version": 2, "tasks": tasks}))
    return file


def _row(item: object, support: object) -> dict[str, object]:
    return {"item": item, "support": support}


IMPOSSIBLE: dict[str, tuple[list[dict[str, object]], dict[str, object], str]] = {
    "a fixed item": (
        [_row("block_0", "block_1")],
        {"fixed": True},
        "the goal moves 'block_0', which is fixed",
    ),
    "a wide item": ([_row("block_0", "block_1")], {"size": [5, 5, 5]}, "wider than 0.8 m; move another"),
    "a table as the item": ([_row("table", "block_1")], {}, "expected a Movable, and 'table' is a Table"),
    "a number as the item": ([_row(3, "block_1")], {}, "expected the name of an object in the scene"),
    "an item in two places": (
        [_row("block_0", "block_1"), _row("block_0", "block_2")],
        {},
        "a second row for block_0; leave out one",
    ),
    "a row twice": ([_row("block_0", "block_1")] * 2, {}, "a second row for block_0; leave out one"),
    "a thin item": (
        [_row("block_0", "block_1")],
        {"size": [0.05, 0.05, 1e-6]},
        "sizes of 'block_0' from 0.0001 to 100 m",
    ),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_a_task_that_cannot_be_carried_out_names_its_file_and_itself(
    file: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    goal, block_0, said = IMPOSSIBLE[name]
    words = ["eval", "block_stacking", "block_stacking", "--expert", "-n", "1"]
    assert run([*words, "--tasks", str(_of_blocks(file, goal, **block_0))]) == 2
    told = capsys.readouterr().err
    assert said in told and str(file) in told and "one" in told and told.count("\n") == 1


def test_what_cannot_be_moved_cannot_be_grasped() -> None:
    block = SceneObject("block_0", "Block", (0.05, 0.05, 0.05), fixed=True)
    world = KinematicWorld()
    world.reset(Scene((block,), {"block_0": (0.5, 0.0, 0.025)}, {}), 0)
    assert world.call("grasp", ("block_0",)).failure is Failure.NOT_READY


def test_an_object_without_volume_is_a_sentence_in_the_bullet_world() -> None:
    sheet = SceneObject("sheet", "Block", (0.05, 0.05, 1e-6))
    with pytest.raises(NtpError, match="cannot make 'sheet'.*give the object another size"):
        ArmWorld("bullet").reset(Scene((sheet,), {"sheet": (0.5, 0.0, 0.1)}, {}), 0)
