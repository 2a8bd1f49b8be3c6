"""Tables of poses that were recorded elsewhere become the demonstrations that they show."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import csv, parquet
from scipy.spatial.transform import Rotation

import ntp_dsl
from ntp_dsl.api import Task
from ntp_dsl.cli.app import run
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.demonstration_files import read_demonstration
from ntp_dsl.demonstrations.pose_maps import read_map

WORDS = ["import-demo", "block_stacking", "few_placements", "--seed", "4"]
ORIGIN, ROTATION = (0.4, -0.1, 0.02), (0.0, 10.0, 90.0)
MARKER = (0.01, 0.0, 0.02)  # from a block's centre, in its own frame [m]
WIDTHS = {True: 48.0, False: 80.0}  # of the fingers [mm]


@pytest.fixture(scope="module")
def task() -> Task:
    return ntp_dsl.draw(ntp_dsl.load("block_stacking"), "few_placements", seed=4)


@pytest.fixture(scope="module")
def shown(task: Task) -> Demonstration:
    return ntp_dsl.demonstrate(task).demonstration


def as_tracked(shown: Demonstration) -> dict[str, np.ndarray]:
    """Return what a camera elsewhere sees of markers on the blocks, in millimetres and milliseconds."""
    turn = Rotation.from_euler("xyz", ROTATION, degrees=True)

    def seen(points: np.ndarray) -> np.ndarray:
        return np.asarray(1000 * turn.inv().apply(points - ORIGIN))

    columns = {"t": 5000 + 1000 * shown.times.astype(float)}
    columns["width"] = np.array([WIDTHS[bool(each)] for each in shown.closed])
    columns |= dict(zip(("hx", "hy", "hz"), seen(shown.grippers).T, strict=True))
    assert shown.orientations is not None
    for index, name in enumerate(shown.names):
        if name == "table":
            continue
        own = Rotation.from_quat(shown.orientations[:, index])
        points = seen(shown.positions[:, index] + own.apply(MARKER))
        columns |= {f"{name}.{axis}": points[:, k] for k, axis in enumerate("xyz")}
        turns = (turn.inv() * own).as_quat()
        columns |= {f"{name}.q{axis}": turns[:, k] for k, axis in enumerate("xyzw")}
    return columns


def map_of(shown: Demonstration, more: str = "") -> str:
    rows = [
        *("[time]", 'column = "t"', 'unit = "ms"'),
        *("[frame]", 'unit = "mm"', f"origin = {[*ORIGIN]}", f"rotation = {[*ROTATION]}"),
        *("[gripper]", 'position = ["hx", "hy", "hz"]', 'closed = "width"', "below = 60.0"),
    ]
    for name in shown.names:
        if name != "table":
            rows += [
                f"[objects.{name}]",
                f"position = {[f'{name}.{axis}' for axis in 'xyz']}",
                f"orientation = {[f'{name}.q{axis}' for axis in 'xyzw']}",
                f"centre = {[-each for each in MARKER]}",
            ]
    return "\n".join([more, *rows])


def write(folder: Path, columns: dict[str, np.ndarray], text: str, ending: str = "csv") -> list[str]:
    """Write a table and its map; return the words of the command."""
    table = pa.table({name: pa.array(values, from_pandas=True) for name, values in columns.items()})
    path = folder / f"poses.{ending}"
    csv.write_csv(table, path) if ending == "csv" else parquet.write_table(table, path)
    (folder / "map.toml").write_text(text)
    return [*WORDS, str(path), "--map", str(folder / "map.toml"), "--out", str(folder / "mine.parquet")]


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_poses_of_another_frame_and_unit_become_the_same_demonstration(
    tmp_path: Path, task: Task, shown: Demonstration, ending: str
) -> None:
    assert run(write(tmp_path, as_tracked(shown), map_of(shown), ending)) == 0
    found = read_demonstration(tmp_path / "mine.parquet")
    assert {*found.objects} == {*task.objects}
    order = [found.names.index(name) for name in shown.names]
    assert found.positions[:, order] == pytest.approx(shown.positions, abs=1e-6)
    assert found.grippers == pytest.approx(shown.grippers, abs=1e-6)
    assert (found.closed == shown.closed).all()
    assert found.times == pytest.approx(shown.times - shown.times[0], abs=1e-4)


def test_what_was_converted_is_done(tmp_path: Path, shown: Demonstration) -> None:
    assert run(write(tmp_path, as_tracked(shown), map_of(shown))) == 0
    words = ["few_placements", "--seed", "4", "--demo", str(tmp_path / "mine.parquet")]
    assert run(["read", "block_stacking", *words]) == 0
    assert run(["run", "block_stacking", *words, "--world", "kinematic"]) == 0


def test_short_gaps_in_the_tracking_are_bridged_and_long_ones_are_told(
    tmp_path: Path, shown: Demonstration, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = as_tracked(shown)
    columns["hx"][5:8] = np.nan
    assert run(write(tmp_path, columns, map_of(shown))) == 0
    found = read_demonstration(tmp_path / "mine.parquet")
    assert found.grippers[5:8] == pytest.approx(shown.grippers[5:8], abs=0.03)
    columns["hx"][5:30] = np.nan
    (tmp_path / "mine.parquet").unlink()
    assert run(write(tmp_path, columns, map_of(shown))) == 2
    assert "'hx' is empty for 2." in capsys.readouterr().err
    assert not (tmp_path / "mine.parquet").exists()
    assert run(write(tmp_path, columns, map_of(shown, "gap = 4.0"))) == 0


def test_the_hand_stays_as_it_was_where_nobody_saw_it(tmp_path: Path, shown: Demonstration) -> None:
    columns = as_tracked(shown)
    at = int(np.argmax(shown.closed))
    columns["width"] = columns["width"].copy()
    columns["width"][at : at + 2] = np.nan
    assert run(write(tmp_path, columns, map_of(shown))) == 0
    closed = read_demonstration(tmp_path / "mine.parquet").closed
    assert (closed != shown.closed).nonzero()[0].tolist() == [at, at + 1]


def test_a_quaternion_and_its_opposite_are_one_turn(tmp_path: Path, shown: Demonstration) -> None:
    columns = as_tracked(shown)
    for axis in "xyzw":
        column = columns[f"block_0.q{axis}"]
        column[10:] *= -1
        column[9:12] = np.nan
    assert run(write(tmp_path, columns, map_of(shown))) == 0
    found = read_demonstration(tmp_path / "mine.parquet")
    index = found.names.index("block_0")
    assert found.positions[8:13, index] == pytest.approx(
        shown.positions[8:13, shown.names.index("block_0")], abs=1e-3
    )


def test_stamps_of_nanoseconds_since_1970_are_times(tmp_path: Path, shown: Demonstration) -> None:
    columns = as_tracked(shown)
    columns["t"] = 1_700_000_000_000_000_000 + (1e9 * shown.times.astype(float)).astype(np.int64)
    assert run(write(tmp_path, columns, map_of(shown).replace('"ms"', '"ns"'))) == 0
    times = read_demonstration(tmp_path / "mine.parquet").times
    assert times == pytest.approx(shown.times - shown.times[0], abs=1e-4)


def test_rows_that_are_missing_are_told(
    tmp_path: Path, shown: Demonstration, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = {name: np.delete(column, slice(20, 40)) for name, column in as_tracked(shown).items()}
    assert run(write(tmp_path, columns, map_of(shown))) == 2
    assert "expected rows all along, found none for 2." in capsys.readouterr().err


def test_a_hand_that_never_closes_is_told(
    tmp_path: Path, shown: Demonstration, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(write(tmp_path, as_tracked(shown), map_of(shown).replace("60.0", "10.0"))) == 0
    error = capsys.readouterr().err
    assert "the hand closes 0 times" in error and "the hand never closes" in error


def test_nothing_that_exists_is_replaced(
    tmp_path: Path, shown: Demonstration, capsys: pytest.CaptureFixture[str]
) -> None:
    words = write(tmp_path, as_tracked(shown), map_of(shown))
    (tmp_path / "mine.parquet").write_text("mine")
    assert run(words) == 2
    assert "exists already" in capsys.readouterr().err
    assert (tmp_path / "mine.parquet").read_text() == "mine"


def test_the_template_fits_the_task(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*WORDS, "--template"]) == 0
    text = capsys.readouterr().out
    (tmp_path / "map.toml").write_text(text)
    told, count = read_map(tmp_path / "map.toml"), 40
    names = [name for each in (told.gripper, *told.objects.values()) for name in each.position]
    columns = {name: np.full(count, 0.3) for name in names}
    columns |= {"time": np.arange(count) / 10, "closed": np.zeros(count)}
    assert run(write(tmp_path, columns, text)) == 0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"ms"', '"minutes"', "$.time.unit"),
        ("[objects.block_0]", "[objects.block_x]", "the map has block_x; the scene has block_0"),
        ('"hx"', '"hand"', "no column is called 'hand'; there are t, width, hx"),
        ("below = 60.0", "", "found 80: of a width or a force, the map says `below` or `above`"),
        ("below = 60.0", "below = 60.0\nabove = 60.0", "or above one, found both"),
        ('unit = "mm"', 'unit = "m"', "are these millimetres?"),
        ("below = 60.0", "below = nan", "expected a finite number of 'gripper.below', found nan"),
        ("centre =", "deviation = 0.001\ncentre =", "expected a deviation of all objects or of none"),
        ("centre =", "deviation = -1.0\ncentre =", "deviation"),
        ("orientation = ", "# ", "expected an orientation of 'block_0'"),
        ("[time]", "[tim]", "unknown field `tim`"),
        ("[time]", "time]", "map.toml"),
    ],
)
def test_a_map_that_does_not_fit_is_refused(
    tmp_path: Path, shown: Demonstration, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    text = map_of(shown)
    assert old in text
    assert run(write(tmp_path, as_tracked(shown), text.replace(old, new, 1))) == 2
    error = capsys.readouterr().err
    assert message in error and "Traceback" not in error
    assert not (tmp_path / "mine.parquet").exists()


def test_objects_that_are_missing_are_named(
    tmp_path: Path, shown: Demonstration, capsys: pytest.CaptureFixture[str]
) -> None:
    text = map_of(shown)
    begin, end = text.index("[objects.block_0]"), text.index("[objects.block_1]")
    assert run(write(tmp_path, as_tracked(shown), text[:begin] + text[end:])) == 2
    assert "the map lacks block_0: say in which columns of" in capsys.readouterr().err


def test_a_file_of_words_is_refused(
    tmp_path: Path, shown: Demonstration, capsys: pytest.CaptureFixture[str]
) -> None:
    words = write(tmp_path, as_tracked(shown), map_of(shown))
    columns = {**as_tracked(shown), "hx": np.array(["far"] * len(shown))}
    assert run(write(tmp_path, columns, map_of(shown))) == 2
    assert "expected numbers in 'hx'" in capsys.readouterr().err
    (tmp_path / "poses.csv").write_text("")
    assert run(words) == 2
    assert "expected CSV" in capsys.readouterr().err
