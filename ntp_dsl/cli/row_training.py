"""Learning the row of one program from traces, and what is said of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from ntp_dsl.cli.display import messages, print_json, progress
from ntp_dsl.cli.trace_folders import traces_in
from ntp_dsl.common.resources import examples_folder, library_folder
from ntp_dsl.common.text import counted
from ntp_dsl.core.learnt.bodies import lines_of
from ntp_dsl.core.learnt.learning import learn
from ntp_dsl.core.learnt.learnt_rows import LearntRow, read_row, rows_file, save_row
from ntp_dsl.core.one_core import load_one_core, shipped_core
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Program, Registry
from ntp_dsl.semantics.value_checks import guess
from ntp_dsl.traces.reader import read_trace
from ntp_dsl.traces.schema import PolicyKind
from ntp_dsl.traces.trace import Trace
from ntp_dsl.user_code.loading import load_with_python

FORESEEN = 0.8  # share of the decisions below which something is missing


def train_row(library: Path, name: str, data: Sequence[Path], out: Path | None, json: bool) -> int:
    """Learn the row of one program, write it, and say what it is. Raises `NtpError` where none can be."""
    registry = load_with_python(library)
    program = registry.programs.get(name)
    if program is None:
        raise NtpError(f"library '{registry.name}' has no program '{name}'{guess(name, registry.programs)}")
    path = out or rows_file(program)
    if path is None:
        raise NtpError(f"'{name}' is in no file: say with --out where its row is to be written")
    if out is None and any(path.is_relative_to(each) for each in (examples_folder(), library_folder())):
        raise NtpError(
            f"{path.parent} ships with the package: copy the library and train the copy, or say with --out "
            "where the row is to be written"
        )
    if path.exists():
        _check_is_row(path, name)
    row = learn(registry, load_one_core(shipped_core()).dispatch, name, _experts_traces(data))
    if row.foreseen < FORESEEN and out is None:
        for line in _told(registry, program, row):
            messages.print(line)
        raise NtpError(
            f"nothing was written, as '{name}' would be decided worse than by what decides now: say with "
            "--out where the row is to be written all the same"
        )
    save_row(row, path)
    if json:
        print_json({"row": str(path), "learnt": row})
    else:
        for line in _told(registry, program, row):
            messages.print(line)
        used = "" if out is None else f"move it beside {library} to use it; "
        messages.print(f"{path}: {used}it holds while '{name}' and what it calls are declared as they are")
    return 0


def _check_is_row(path: Path, name: str) -> None:
    """Raise `NtpError` where a file is not one that this command would have written for a program."""
    try:
        row = read_row(path)
    except NtpError as error:
        raise NtpError(f"{path}: exists, and is no learnt row: nothing is replaced") from error
    if row.program != name:
        raise NtpError(f"{path}: is the row of '{row.program}': nothing is replaced")


def _experts_traces(folders: Sequence[Path]) -> list[Trace]:
    """Return the traces of experts that did not fail; the others show no right decisions."""
    files = [file for folder in folders for file in traces_in(folder)]
    found, left_out = [], 0
    with progress("reading traces", len(files)) as bar:
        for file in files:
            trace = read_trace(file)
            is_right = trace.end is not None and trace.end.success is not False
            if trace.header.policy is PolicyKind.SCRIPTED and is_right:
                found.append(trace)
            else:
                left_out += 1
            bar.advance()
    if left_out:
        messages.print(f"{counted(left_out, 'trace')} left out: not by an expert, or failed")
    return found


def _told(registry: Registry, program: Program, row: LearntRow) -> Iterator[str]:
    seen = f"{counted(row.decisions, 'decision')} in {counted(row.traces, 'trace')}"
    yield f"{program.name}: learnt from {seen}"
    yield from (f"    {each}" for each in lines_of(registry, program, row.calls))
    terms = row.preference.terms
    liked = f"those with {row.preference} come first" if terms else "none is preferred: they come in order"
    yield f"of the calls that are due, {liked}"
    if row.due < row.decisions:
        left_out = counted(row.decisions - row.due, "decision")
        yield f"{left_out} left out: the call that was made was not due by the contracts"
    yield f"{row.foreseen:.0%} of the decisions are foreseen by what other traces show"
    if row.foreseen < FORESEEN:
        yield (
            "what the others hang on cannot be seen of a call: declare it as a predicate or a reading of "
            "the call's objects, or record more"
        )
