"""Dispatch of the words after `ntp` to a command's function, and of its exceptions to an exit status.

To add a command, add a line to `COMMANDS` and a module of that name with a function `command`, whose
annotations are the options and whose docstring is the help, with an example. It returns the exit
status; None is 0.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any, NoReturn

import typer
from typer.core import TyperCommand, TyperGroup

from ntp_dsl.cli import extras
from ntp_dsl.language.diagnostics.diagnostics import NtpError, SourceError, TaskFailed, nearest

DONE, NO, MISUSE, INTERRUPTED = 0, 1, 2, 130
INTERRUPTION = "interrupted; all files that were written are complete"

Table = Mapping[str, "str | Table"]

COMMANDS: Table = {
    "check": "Check libraries, and report every error with its location.",
    "fmt": "Format libraries; comments are kept.",
    "new": "Create a small domain to start from.",
    "graph": "Show the call graph of a library, as a tree or a picture.",
    "demo": "Watch the shipped checkpoint build a structure from one demonstration.",
    "run": "Run a task on the arm, from one demonstration or by the scripted expert.",
    "record": "Record demonstrations and labelled traces from the scripted expert.",
    "train": "Train a core on the recorded traces of a library's expert.",
    "eval": "Run many episodes, and report success and what failures are attributed to.",
    "bench": "Benchmark inverse kinematics, planning or execution against other libraries.",
    "trace": {
        "show": "Show the call tree of a trace in the terminal.",
        "diff": "Show where two traces diverge, and what it is attributed to.",
        "view": "Show one trace, or two side by side, in a browser.",
        "replay": "Compare a policy's decisions at every state of a trace with the trace.",
        "coverage": "Show a library's source with figures from many traces at each line.",
        "export": "Export traces to Perfetto, speedscope or rerun.",
    },
    "import-vat": "Convert a task file of the paper's authors to our own format.",
}
GROUPS = {
    "": "Declare a library of robot tasks, demonstrate a task once, and let the arm do it.",
    "trace": "Inspect and compare what programs did, call by call.",
}


class LazyGroup(TyperGroup):
    """A table of commands, each imported from `ntp_dsl.cli.commands` when it is called."""

    def __init__(self, table: Table, path: tuple[str, ...] = ()) -> None:
        super().__init__(
            name=path[-1] if path else "ntp",
            help=GROUPS[" ".join(path)],
            context_settings={"help_option_names": ["-h", "--help"]},
            rich_markup_mode=None,
            no_args_is_help=True,
        )
        self.table, self.path = table, path

    def list_commands(self, ctx: Any) -> list[str]:
        return list(self.table)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        entry, path = self.table.get(cmd_name), (*self.path, cmd_name)
        if isinstance(entry, Mapping):
            return LazyGroup(entry, path)
        return None if entry is None else _imported(path)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        if args[0] not in self.table:
            ctx.fail(_unknown(f"there is no command '{args[0]}'", args[0], self.table))
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, self._summary(name)) for name in self.table])

    def _summary(self, name: str) -> str:
        entry = self.table[name]
        return entry if isinstance(entry, str) else GROUPS[" ".join((*self.path, name))]


def _imported(path: tuple[str, ...]) -> TyperCommand:
    """Import a command: `trace show` is the function `command` of `ntp_dsl.cli.commands.trace.show`."""
    module = import_module("ntp_dsl.cli.commands." + ".".join(path).replace("-", "_"))
    app = typer.Typer(
        add_completion=False,
        rich_markup_mode=None,
        context_settings={"help_option_names": ["-h", "--help"]},
    )
    app.command(path[-1])(module.command)
    command = typer.main.get_command(app)
    assert isinstance(command, TyperCommand)
    return command


def main() -> NoReturn:
    """Run the command line; the entry point of `ntp`."""
    sys.exit(run(sys.argv[1:]))


def run(words: Sequence[str]) -> int:
    """Run one command line and return its exit status. User errors are reported in a sentence."""
    try:
        status = LazyGroup(COMMANDS).main(list(words), prog_name="ntp", standalone_mode=False)
    except TaskFailed as error:
        return _report(error, NO)
    except SourceError as error:
        return _report_diagnostics(error)
    except NtpError as error:
        return _report(error, MISUSE)
    except OSError as error:
        return _report(f"{error.filename or 'a file'}: {error.strerror or error}", MISUSE)
    except ModuleNotFoundError as error:
        sentence = extras.missing(_command_name(words), error.name)
        if sentence is None:  # not for want of an extra: a fault of ours
            raise
        return _report(sentence, MISUSE)
    except typer.TyperException as error:
        return _report_misuse(error)
    if status == INTERRUPTED:
        _report(INTERRUPTION, INTERRUPTED)
    return status or DONE


def _command_name(words: Sequence[str]) -> str:
    """Return the command that a command line begins with, such as `ntp trace show`."""
    name, table = "ntp", COMMANDS
    for word in words:
        entry = table.get(word)
        if entry is None:
            break
        name += f" {word}"
        if isinstance(entry, str):
            break
        table = entry
    return name


def _report(sentence: object, status: int) -> int:
    text = str(sentence)
    lines = (line if line.isprintable() else repr(line)[1:-1] for line in text.split("\n"))
    print("\n".join(lines), file=sys.stderr)  # what a name contains cannot command the terminal
    return status


def _report_diagnostics(error: SourceError) -> int:
    """Report all errors of a library that a command needs, as `ntp check` does."""
    from ntp_dsl.cli.report import print_diagnostics, summary

    print_diagnostics(error.diagnostics, error.sources, sys.stderr)
    return _report(summary(error.diagnostics), MISUSE)


def _report_misuse(error: typer.TyperException) -> int:
    """Report an unknown or invalid option, the existing ones, and where to read on."""
    sentence = error.format_message().replace("Value error, ", "")
    context: Any = getattr(error, "ctx", None)
    if context is None or sentence.startswith("Usage:"):
        return _report(sentence, MISUSE)
    if (given := getattr(error, "option_name", None)) and sentence.startswith("No such option"):
        known = [name for each in context.command.params for name in each.opts if name[0] == "-"]
        sentence = _unknown(f"there is no option '{given}'", given, [*known, "--help"])
    return _report(f"{sentence}\nsee: {context.command_path} --help", MISUSE)


def _unknown(sentence: str, given: str, known: Mapping[str, object] | Sequence[str]) -> str:
    match = nearest(given, known)
    hint = f"; did you mean '{match}'?" if match else ""
    return f"{sentence}{hint} (available: {', '.join(known)})"
