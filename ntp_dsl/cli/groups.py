"""The table of commands, and the groups of them that import a command when it is called.

To add a command, add a line to `COMMANDS` and a module of that name with a function `command`, whose
annotations are the options and whose docstring is the help, with an example. It returns the exit
status; None is 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.diagnostics.spelling import nearest

Table = Mapping[str, "str | Table"]

COMMANDS: Table = {
    "check": "Check libraries, and report every error with its location.",
    "fmt": "Format libraries; comments are kept.",
    "new": "Create a small domain to start from.",
    "graph": "Show the call graph of a library, as a tree or a picture.",
    "demo": "Watch the shipped checkpoint build a structure from one demonstration.",
    "run": "Run a task on the arm, from one demonstration or by the scripted expert.",
    "read": "Print what a demonstration says, as a goal that can be edited and run.",
    "record": "Record demonstrations and labelled traces from the scripted expert.",
    "train": "Train a core on the recorded traces of a library's expert.",
    "pretrain": "Make the core that runs any library; it needs no data.",
    "eval": "Run many episodes, and report success and what failures are attributed to.",
    "soup": "Write random sound libraries, to train on and to test with.",
    "bench": "Benchmark inverse kinematics, planning or execution against other libraries.",
    "trace": {
        "show": "Show the call tree of a trace in the terminal.",
        "explain": "Say in plain words why a call was made, and what came of it.",
        "diff": "Show where two traces diverge, and what it is attributed to.",
        "view": "Show one trace, or two side by side, in a browser.",
        "replay": "Compare a policy's decisions at every state of a trace with the trace.",
        "report": "Write a report of many episodes, for a browser.",
        "rerun": "Run again what a trace records, to step it, or to its end where it was cut off.",
        "coverage": "Show a library's source with figures from many traces at each line.",
        "export": "Export traces to Perfetto, speedscope or rerun.",
    },
    "import-demo": "Convert a table of poses into a demonstration.",
    "import-vat": "Convert a task file of the paper's authors to our own format.",
}
GROUPS = {
    "": "Declare a library of robot tasks, demonstrate a task once, and let the arm do it.",
    "trace": "Inspect and compare what programs did, call by call.",
}


class Misuse(NtpError):
    """The words are no command line; the message says which words are."""


def invoke(words: Sequence[str]) -> int:
    """Run the command of a command line, and return its exit status. Raises `Misuse`."""
    group = LazyGroup(COMMANDS)
    try:
        with group.make_context("ntp", list(words)) as context:
            return group.invoke(context) or 0
    except typer.Exit as end:
        return end.exit_code
    except typer.TyperException as error:
        raise Misuse(_explained(error)) from error


def command_name(words: Sequence[str]) -> str:
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


def _explained(error: typer.TyperException) -> str:
    """Return what is wrong with an option or its value, the existing ones, and where to read on."""
    sentence = error.format_message().replace("Value error, ", "")
    context: Any = getattr(error, "ctx", None)
    if context is None or sentence.startswith("Usage:"):
        return sentence
    if (given := getattr(error, "option_name", None)) and sentence.startswith("No such option"):
        known = [name for each in context.command.params for name in each.opts if name[0] == "-"]
        sentence = _unknown(f"there is no option '{given}'", given, [*known, "--help"])
    return f"{sentence}\nsee: {context.command_path} --help"


def _unknown(sentence: str, given: str, known: Mapping[str, object] | Sequence[str]) -> str:
    match = nearest(given, known)
    hint = f"; did you mean '{match}'?" if match else ""
    return f"{sentence}{hint} (available: {', '.join(known)})"
