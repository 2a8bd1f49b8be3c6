"""Demonstrations are kept as they were shown, and what is not a demonstration is told so."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet

from ntp_dsl.demonstrations.demonstration import Demonstration, Origin, Recorder, Specification
from ntp_dsl.demonstrations.demonstration_files import read_demonstration, write_demonstration
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.semantics.observation import DeclaredFact, Record, SceneObject
from ntp_dsl.worlds.kinematic import KinematicWorld
from ntp_dsl.worlds.protocol import Scene

THINGS = (
    SceneObject("a", "Block", (0.05, 0.05, 0.05)),
    SceneObject("b", "Block", (0.05, 0.05, 0.05)),
    SceneObject("table", "Table", (1.5, 1.5, 0.04)),
)
PLACES = {"a": (0.45, 0.1, 0.025), "b": (0.55, -0.1, 0.025), "table": (0.5, 0.0, -0.02)}


def shown() -> Demonstration:
    world = KinematicWorld()
    world.reset(Scene(THINGS, PLACES), seed=4)
    recorder = Recorder(world)
    for api, arguments in [("move_to", ("a",)), ("grasp", ("a",)), ("move_to", ("b",))]:
        assert world.call(api, arguments).achieved
    return recorder.demonstration(Origin(task="a on b", seed=4))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "a.demo.parquet"
    write_demonstration(shown(), path)
    return path


def test_a_demonstration_comes_back_as_it_was_written(file: Path) -> None:
    written, read = shown(), read_demonstration(file)
    assert (read.objects, read.origin) == (written.objects, written.origin)
    for name in ("positions", "grippers", "relative", "closed", "times"):
        expected, found = getattr(written, name), getattr(read, name)
        assert found.dtype == expected.dtype and np.array_equal(found, expected)
    assert list(file.parent.iterdir()) == [file]


def test_positions_are_relative_to_the_gripper() -> None:
    demonstration = shown()
    held = demonstration.relative[:, demonstration.names.index("a")][demonstration.closed]
    assert len(held) > 10 and np.abs(held).max() < 1e-6


def test_frames_are_a_tenth_of_a_second_apart_or_mark_the_end_of_a_call() -> None:
    steps = np.diff(shown().times)
    assert (steps >= 0).all() and steps.max() < 0.16


def test_a_file_that_was_cut_off_is_told_so(file: Path) -> None:
    whole = file.read_bytes()
    for length in [0, 1, 4, len(whole) // 2, len(whole) - 9, len(whole) - 1]:
        file.write_bytes(whole[:length])
        with pytest.raises(NtpError, match="expected a demonstration .*truncated"):
            read_demonstration(file)


@pytest.mark.parametrize("content", [b"library a\n", b"\x89PNG\r\n\x1a\n", b"PAR1PAR1", b"{}"])
def test_a_foreign_file_is_told_so(file: Path, content: bytes) -> None:
    file.write_bytes(content)
    with pytest.raises(NtpError, match="expected a demonstration"):
        read_demonstration(file)


def test_a_foreign_table_is_told_what_it_holds(file: Path) -> None:
    parquet.write_table(pa.table({"price": [1.0], "name": ["x"]}), file)
    with pytest.raises(NtpError, match="found a table of price, name"):
        read_demonstration(file)


def test_all_that_observations_carry_is_kept(file: Path) -> None:
    whole = shown()
    rng = np.random.default_rng(0)
    count = len(whole)
    written = replace(
        whole,
        orientations=rng.normal(size=(count, 3, 4)).astype(np.float32),
        deviations=rng.uniform(0, 0.01, (count, 3)).astype(np.float32),
        facts=tuple(frozenset([DeclaredFact("open", ("b",))] if n % 2 else []) for n in range(count)),
        origin=Origin(goal=(Record("Placement", (("item", "a"), ("support", "b"))),)),
    )
    write_demonstration(written, file)
    read = read_demonstration(file)
    assert read.orientations is not None and np.array_equal(read.orientations, written.orientations)
    assert read.deviations is not None and np.array_equal(read.deviations, written.deviations)
    assert (read.facts, read.origin) == (written.facts, written.origin)


def test_a_demonstration_of_the_first_version_shows_what_it_showed(file: Path) -> None:
    """Its places were relative to the gripper."""
    whole = shown()
    header = {
        "format": "ntp-demonstration",
        "version": 1,
        "things": [{"name": t.name, "type": t.type, "size": t.size, "shape": "box"} for t in THINGS],
        "notes": {"task": "a on b", "seed": 4, "goal": [{"item": "a", "support": "b"}]},
    }
    columns = {"time": whole.times, "closed": whole.closed}
    columns |= {f"position.{name}": list(whole.relative[:, index]) for index, name in enumerate(whole.names)}
    table = pa.table(columns).replace_schema_metadata({"ntp-demonstration": json.dumps(header)})
    parquet.write_table(table, file)
    read = read_demonstration(file)
    assert read.objects == THINGS and np.array_equal(read.relative, whole.relative)
    assert [row.fields for row in read.origin.goal] == [(("item", "a"), ("support", "b"))]


@pytest.mark.parametrize("column", ["time", "closed", "gripper", "position.b"])
def test_a_missing_column_is_named(file: Path, column: str) -> None:
    table = parquet.read_table(file)
    parquet.write_table(table.drop_columns([column]), file)
    with pytest.raises(NtpError, match=f"lacks a column or a field: there is no '{column}'"):
        read_demonstration(file)


def test_what_is_not_a_number_is_refused(file: Path) -> None:
    demonstration = shown()
    demonstration.positions[2, 0, 1] = np.nan
    write_demonstration(demonstration, file)
    with pytest.raises(NtpError, match="finite"):
        read_demonstration(file)


def test_a_file_that_is_not_there_says_what_makes_one(tmp_path: Path) -> None:
    with pytest.raises(NtpError, match="no such demonstration; `ntp record` makes them"):
        read_demonstration(tmp_path / "none.demo.parquet")


class Sentences:
    modality = "language"

    def __init__(self, *sentences: str) -> None:
        self.sentences = sentences

    def __len__(self) -> int:
        return len(self.sentences)


class Frames(Sentences):
    modality = "video"


def test_a_specification_is_whatever_has_steps_and_a_modality() -> None:
    specifications: list[Specification] = [shown(), Sentences("put a on b"), Frames("0", "1")]
    assert [each.modality for each in specifications] == ["trajectory", "language", "video"]
    assert all(len(each) for each in specifications)


MADE_WRONG = {
    "millimetres": ("gripper", lambda rows: [[1000 * each for each in row] for row in rows], "millimetres"),
    "times that run back": ("time", lambda rows: rows[::-1], "do not decrease, found a step back at frame"),
    "one time": ("time", lambda rows: [0.5] * len(rows), "that increase, found 0.5 in all frames"),
    "no number": ("position.a", lambda rows: [[float("nan")] * 3, *rows[1:]], "'position.a' at frame 0"),
    "words for the hand": ("closed", lambda rows: ["false"] * len(rows), "true or false, or 1 or 0"),
    "half a hand": ("closed", lambda rows: [0.5] * len(rows), "true or false, or 1 or 0"),
}


@pytest.mark.parametrize("fault", MADE_WRONG)
def test_what_no_robot_can_have_shown_is_refused(file: Path, fault: str) -> None:
    column, change, message = MADE_WRONG[fault]
    table = parquet.read_table(file)
    rows = pa.array(change(table[column].to_pylist()))
    changed = table.set_column(table.column_names.index(column), column, rows)
    parquet.write_table(changed.replace_schema_metadata(table.schema.metadata), file)
    with pytest.raises(NtpError, match=message):
        read_demonstration(file)


def test_a_file_made_elsewhere_needs_neither_header_nor_table(file: Path) -> None:
    whole, table = shown(), parquet.read_table(file)
    closed = pa.array(whole.closed.astype(int))
    bare = table.drop_columns(["position.table", "closed"]).append_column("closed", closed)
    parquet.write_table(bare.replace_schema_metadata({}), file)
    read = read_demonstration(str(file), scene=THINGS)
    assert read.names == whole.names and np.array_equal(read.positions, whole.positions)
    assert np.array_equal(read.closed, whole.closed)
    with pytest.raises(NtpError, match="no header; give the objects of its scene"):
        read_demonstration(file)
