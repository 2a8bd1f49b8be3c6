"""From the words after `ntp` to one command's function, and from what it raises to an exit status.

To add a command: a line in `COMMANDS`, and a module of that name with a function `command`, whose
annotations are the options and whose docstring is the help, with an example. What it returns is
the exit status; None is 0.
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
INTERRUPTION = "interrupted; the files that are written are whole"

Table = Mapping[str, "str | Table"]

COMMANDS: Table = {
    "check": "Say whether libraries are sound, and every mistake that is in them.",
    "fmt": "Put libraries into their one layout; comments stay.",
    "new": "Make a small domain to start from.",
    "graph": "Show who calls whom in a library, as a tree or a picture.",
    "demo": "Watch the shipped checkpoint build what it was shown once.",
    "run": "Carry out a task on the arm, from one demonstration or by the expert.",
    "record": "Record demonstrations and labelled traces from the scripted expert.",
    "train": "Train a core to dispatch over a library, from the traces of its expert.",
    "eval": "Run many episodes and count, with who is to blame for every failure.",
    "bench": "Measure the arm: inverse kinematics, planning, execution, beside its peers.",
    "trace": {
        "show": "Show the call tree of a trace in the terminal.",
        "diff": "Say where one trace leaves another, and who is to blame.",
        "view": "Look at one trace, or two side by side, in a browser.",
        "replay": "Ask a policy at every state of a trace what it would do.",
        "coverage": "Show a library's source with what many traces did at each line.",
        "export": "Write traces for Perfetto, speedscope or rerun.",
    },
    "import-vat": "Turn a task file of the paper's authors into our own format.",
}
GROUPS = {
    "": "Declare a library of robot tasks, show a task once, and the arm does it.",
    "trace": "Look at what a program did, call by call.",
}


class LazyGroup(TyperGroup):
    """A table of commands, each imported from `ntp_dsl.cli.commands` when it is called, and not before."""

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
            ctx.fail(_no_such(f"there is no command '{args[0]}'", args[0], self.table))
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, self._summary(name)) for name in self.table])

    def _summary(self, name: str) -> str:
        entry = self.table[name]
        return entry if isinstance(entry, str) else GROUPS[" ".join((*self.path, name))]


def _imported(path: tuple[str, ...]) -> TyperCommand:
    """The command `trace show` is the function `command` of `ntp_dsl.cli.commands.trace.show`."""
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
    """The entry point of `ntp`."""
    sys.exit(run(sys.argv[1:]))


def run(words: Sequence[str]) -> int:
    """Carry out one command line; the exit status. Mistakes of the user are one plain sentence."""
    try:
        status = LazyGroup(COMMANDS).main(list(words), prog_name="ntp", standalone_mode=False)
    except TaskFailed as error:
        return _complain(error, NO)
    except SourceError as error:
        return _show(error)
    except NtpError as error:
        return _complain(error, MISUSE)
    except OSError as error:
        return _complain(f"{error.filename or 'a file'}: {error.strerror or error}", MISUSE)
    except ModuleNotFoundError as error:
        sentence = extras.missing(_command_name(words), error.name)
        if sentence is None:  # not for want of an extra: a fault of ours
            raise
        return _complain(sentence, MISUSE)
    except typer.TyperException as error:
        return _misuse(error)
    if status == INTERRUPTED:
        _complain(INTERRUPTION, INTERRUPTED)
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


def _complain(sentence: object, status: int) -> int:
    print(sentence, file=sys.stderr)
    return status


def _show(error: SourceError) -> int:
    """The library that a command was to use has mistakes: all of them, as `ntp check` shows them."""
    from ntp_dsl.cli.report import print_diagnostics, summary

    print_diagnostics(error.diagnostics, error.sources, sys.stderr)
    return _complain(summary(error.diagnostics), MISUSE)


def _misuse(error: typer.TyperException) -> int:
    """An unknown or impossible option: what is wrong, what there is, and where to read on."""
    sentence = error.format_message().replace("Value error, ", "")
    context: Any = getattr(error, "ctx", None)
    if context is None or sentence.startswith("Usage:"):
        return _complain(sentence, MISUSE)
    if (given := getattr(error, "option_name", None)) and sentence.startswith("No such option"):
        known = [name for each in context.command.params for name in each.opts if name[0] == "-"]
        sentence = _no_such(f"there is no option '{given}'", given, [*known, "--help"])
    return _complain(f"{sentence}\nsee: {context.command_path} --help", MISUSE)


def _no_such(sentence: str, given: str, known: Mapping[str, object] | Sequence[str]) -> str:
    meant = nearest(given, known)
    guess = f"; did you mean '{meant}'?" if meant else ""
    return f"{sentence}{guess} (there is: {', '.join(known)})"
