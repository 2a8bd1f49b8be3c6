"""`ntp trace export`: traces for other viewers."""

from __future__ import annotations

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from ntp_dsl.cli.display import answers, print_json
from ntp_dsl.cli.options import Json
from ntp_dsl.cli.outputs import check_no_input
from ntp_dsl.common.files import written_whole
from ntp_dsl.traces.export import chrome, otlp
from ntp_dsl.traces.export.rerun_recording import write_recording
from ntp_dsl.traces.reader import read_trace


class Format(StrEnum):
    CHROME = "chrome"
    RERUN = "rerun"
    OTLP = "otlp"


ENDINGS = {Format.CHROME: ".json", Format.RERUN: ".rrd", Format.OTLP: ".otlp.json"}
OPENED_BY = {
    Format.CHROME: "Perfetto or speedscope",
    Format.RERUN: "rerun",
    Format.OTLP: "what takes OpenTelemetry, such as Jaeger: POST it to the collector's /v1/traces",
}


def command(
    first: Annotated[Path, typer.Argument(metavar="A", help="A trace.")],
    second: Annotated[
        Path | None, typer.Argument(metavar="[B]", help="A second trace in the same file.")
    ] = None,
    format: Annotated[
        Format,
        typer.Option(
            help="chrome: trace events in JSON; otlp: OpenTelemetry spans in JSON; "
            "rerun: a recording (needs the extra 'viz')."
        ),
    ] = Format.CHROME,
    out: Annotated[
        Path | None, typer.Option(help="File to write; by default trace.json, trace.otlp.json or trace.rrd.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Export one trace, or two in one file, for another viewer.

    Chrome's format shows the time spent in nested calls; Perfetto, speedscope and others open it. So do
    OpenTelemetry's spans, which end when the trace's file was written. A rerun
    recording shows the scene, the calls, the probabilities and the camera's pictures over time.

    Example: ntp trace export scripted.trace.jsonl learned.trace.jsonl --format rerun --out both.rrd
    """
    files = [first] if second is None else [first, second]
    traces = [read_trace(file) for file in files]
    path = out or Path(f"trace{ENDINGS[format]}")
    check_no_input(path, files)
    with written_whole(path) as partial:
        if format is Format.RERUN:
            write_recording(traces, [file.parent for file in files], partial)
        else:
            ended = [file.stat().st_mtime for file in files]
            found = chrome.document(traces) if format is Format.CHROME else otlp.document(traces, ended)
            partial.write_text(json.dumps(found, allow_nan=False), encoding="utf-8")
    if as_json:
        print_json({"file": str(path), "format": str(format), "bytes": path.stat().st_size})
    else:
        answers.print(f"wrote {path}: open it with {OPENED_BY[format]}")
