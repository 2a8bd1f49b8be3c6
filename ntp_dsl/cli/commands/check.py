"""`ntp check`: all diagnostics of a library."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from ntp_dsl.cli.report import difference, print_diagnostics, print_lines, summary
from ntp_dsl.common.files import rewrite
from ntp_dsl.common.text import counted
from ntp_dsl.language.diagnostics.diagnostics import Diagnostic, Edit, NtpError, has_errors
from ntp_dsl.language.diagnostics.rendering import shown_path
from ntp_dsl.language.loader import Report, check_files, find, read
from ntp_dsl.language.registry import Registry
from ntp_dsl.language.syntax.nodes import Span

Texts = Mapping[Path, str]  # in place of what is in the files
Sources = dict[Path | None, str]
Found = tuple[list[Diagnostic], Sources]  # diagnostics, and the texts that they refer to


class Format(StrEnum):
    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"


def command(
    files: Annotated[list[Path], typer.Argument(metavar="FILE", help="Libraries or folders.")],
    static: Annotated[bool, typer.Option("--static", help="Check the text only; simulate nothing.")] = False,
    execute: Annotated[
        bool, typer.Option("--execute", help="Import and run the libraries' own Python functions.")
    ] = False,
    format: Annotated[Format, typer.Option(help="Output as text, JSON, or SARIF 2.1.0.")] = Format.TEXT,
    fix: Annotated[
        bool, typer.Option("--fix", help="Apply the fixes that are certain; offers are left to you.")
    ] = False,
    diff: Annotated[
        bool, typer.Option("--diff", help="Show exactly what --fix would write; write nothing.")
    ] = False,
    seed: Annotated[
        int,
        typer.Option(
            min=0, help="Seed of the scenes, goals, starts and arguments that the simulation draws."
        ),
    ] = 0,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the traces of trials that failed: LIBRARY.TASK_00000.trace.jsonl, …"),
    ] = None,
) -> int:
    """Check libraries, and report every error with its location.

    The text is checked first. If it has no errors, the library is simulated in the kinematic world, to
    find apis that violate their contract, goals that hold from the start or are never reached, and
    experts that never end. Each task is tried from several starts; another --seed draws others. With
    --out, the trace of every trial that failed is written, for `ntp trace show`, `explain` and `view`.

    A fix is certain if you would surely have written just that, as for a misspelt name or a foreign unit;
    every other one is an offer. With --fix, a fix with which the library is worse is taken back. Exit
    status: 0 no errors (warnings and notes do not count), 1 errors, 2 there is no such file.

    Example: ntp check examples/block_stacking --seed 1 --out runs/check
    """
    if static and execute:
        raise NtpError("--static simulates nothing and --execute everything: choose one")
    if static and out is not None:
        raise NtpError("--static simulates nothing, so that there are no traces for --out: choose one")
    if fix and diff:
        raise NtpError("--fix writes files and --diff only shows changes: choose one")
    checks = _Checks([find(file) for file in files], execute, seed)
    texts: Texts = {}
    if fix or diff:
        from ntp_dsl.cli.mending import mend

        simulate = None if static else lambda texts: checks.simulate(texts)[0]
        mended = mend(lambda texts: checks.diagnose(texts)[0], simulate, checks.paths)
        _show_changes(mended.texts, mended.taken_back, format)
        texts = mended.texts if fix else {}
        for path, text in texts.items():
            rewrite(path, text)
    diagnostics, sources = checks.diagnose(texts)
    if not static and not has_errors(diagnostics):
        simulated, more = checks.simulate(texts, out)
        diagnostics, sources = [*diagnostics, *simulated], {**sources, **more}
    if format is Format.TEXT:
        decided = [] if static or has_errors(diagnostics) else checks.who_decides()
        _print_text(checks.paths, diagnostics, sources)
        for line in decided:
            print(line)
    else:
        _print_document(diagnostics, format)
    return int(has_errors(diagnostics))


class _Checks:
    """The checks of some libraries, with other texts in place of those of files; each is made once."""

    def __init__(self, paths: list[Path], execute: bool, seed: int) -> None:
        self.paths = paths
        self._execute, self._seed = execute, seed
        self._simulated: dict[tuple[Path | None, tuple[tuple[Path, str], ...]], Found] = {}
        self._registries: list[Registry] = []  # as they were simulated last

    def diagnose(self, texts: Texts) -> Found:
        """Return the diagnostics of all libraries; those of shared libraries occur once."""
        diagnostics: dict[Diagnostic, None] = {}
        sources: Sources = {}
        for path in self.paths:
            report = _report(path, texts)
            diagnostics |= dict.fromkeys(report.diagnostics)
            sources |= report.sources
        return list(diagnostics), sources

    def simulate(self, texts: Texts, out: Path | None = None) -> Found:
        """Return the diagnostics of the dynamic check.

        Args:
            out: folder for the traces of trials that failed.
        """
        key = out, tuple(sorted(texts.items()))
        if key not in self._simulated:
            self._simulated[key] = self._simulate(texts, out)
        return self._simulated[key]

    def who_decides(self) -> list[str]:
        """Return, of what was simulated, how programs are decided that have a row or are left to Python."""
        from ntp_dsl.cli.python_programs import who_decides

        return [line for each in self._registries for line in who_decides(each, self._execute)]

    def _simulate(self, texts: Texts, out: Path | None) -> Found:
        from ntp_dsl.cli.display import progress
        from ntp_dsl.dynamic.check import check_dynamically
        from ntp_dsl.dynamic.trial_traces import TrialTraces
        from ntp_dsl.user_code.loading import with_python

        diagnostics: dict[Diagnostic, None] = {}
        registries = [(path, _report(path, texts).checked()) for path in self.paths]
        self._registries = []
        traces = TrialTraces(out)
        traces.clear(registry.name for _, registry in registries)
        with progress("simulating", None) as bar:
            for path, checked in registries:
                registry = with_python(checked) if self._execute else checked
                self._registries.append(registry)
                report = lambda name, path=path: bar.describe(f"{shown_path(path)}: {name}")  # noqa: E731
                found = check_dynamically(registry, path, self._seed, report, traces)
                diagnostics |= dict.fromkeys(found)
        if out is not None:
            _print_written(traces.written, out)
        spans = [span for each in diagnostics for span in (each.span, *(note.span for note in each.notes))]
        named = [span.path for span in spans if span.path is not None]
        return list(diagnostics), {path: texts[path] if path in texts else read(path) for path in named}


def _print_written(files: Sequence[Path], out: Path) -> None:
    """Say how many traces there are, and how to look at one."""
    from ntp_dsl.cli.display import messages

    if files:
        written = f"{counted(len(files), 'trace')} of failed trials in {out}"
        messages.print(f"{written}; to look at the first: ntp trace show {files[0]}", soft_wrap=True)
    else:
        messages.print(f"no trial failed: no trace was written to {out}", soft_wrap=True)


def _report(path: Path, texts: Texts) -> Report:
    return check_files(path, {other: text for other, text in texts.items()})


def _show_changes(texts: Texts, taken_back: Sequence[str], format: Format) -> None:
    """Show the lines that change in the files, which are not written yet."""
    stream = sys.stdout if format is Format.TEXT else sys.stderr
    for path, text in texts.items():
        print_lines(difference(path, read(path), text), stream)
    for sentence in taken_back:
        print(sentence, file=stream)


def _print_text(paths: list[Path], diagnostics: Sequence[Diagnostic], sources: Sources) -> None:
    print_diagnostics(diagnostics, sources)
    counts = summary(diagnostics)
    if has_errors(diagnostics):
        fixable = sum(each.fix is not None and each.fix.certain for each in diagnostics)
        print(counts + (f" ({fixable} fixable with --fix)" if fixable else ""))
    else:
        libraries = ", ".join(shown_path(path) for path in paths)
        print(f"sound: {libraries}" + (f" ({counts})" if counts else ""))


def _print_document(diagnostics: Sequence[Diagnostic], format: Format) -> None:
    from ntp_dsl.cli import sarif
    from ntp_dsl.cli.display import print_json

    if format is Format.SARIF:
        print_json(sarif.document(diagnostics))
    else:
        sound = not has_errors(diagnostics)
        print_json({"sound": sound, "diagnostics": [_row(each) for each in diagnostics]})


def _row(diagnostic: Diagnostic) -> dict[str, Any]:
    fix = diagnostic.fix
    return {
        "code": diagnostic.code,
        "severity": diagnostic.severity,
        "message": diagnostic.message,
        "help": diagnostic.help,
        **_place(diagnostic.span),
        "notes": [{"message": note.message, **_place(note.span)} for note in diagnostic.notes],
        "fix": fix and {**_edit(fix), "also": [_edit(each) for each in fix.also], "certain": fix.certain},
    }


def _edit(edit: Edit) -> dict[str, Any]:
    return {"replacement": edit.replacement, **_place(edit.span)}


def _place(span: Span) -> dict[str, Any]:
    return {
        "path": str(span.path) if span.path else None,
        "line": span.line,
        "column": span.column,
        "end_line": span.end_line,
        "end_column": span.end_column,
    }
