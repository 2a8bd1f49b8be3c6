"""The call tree of a running program, one line per call."""

from __future__ import annotations

from typing import Any

from rich.text import Text

from ntp_dsl.cli.display import answers
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Argument

SUCCESSES = ("done", "achieved")


class LiveTree:
    """A watcher of the interpreter that prints programs when they are called and primitives when they end."""

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self._has_root = False

    def __call__(
        self, event: str, depth: int, name: str, arguments: tuple[Argument, ...], detail: Any
    ) -> None:
        is_api = name in self._registry.apis
        objects = ", ".join(argument for argument in arguments if isinstance(argument, str))
        line = Text("  " * depth + f"{name}({objects})", style="" if is_api else "bold")
        if event == "call":
            if is_api or depth == 0 and self._has_root:
                return  # the root is called again to confirm that it is done, but printed once
            self._has_root = True
            if detail is not None:
                line.append(f"  frames {detail[0]}–{detail[1]}", style="dim")
        elif is_api:
            line.append("  ✓" if detail in SUCCESSES else f"  ✗ {detail}", style=_colour(detail))
        elif detail in SUCCESSES:
            return
        else:
            line.append(f"  {detail}", style="yellow")
        answers.print(line)


def _colour(outcome: str) -> str:
    return "green" if outcome in SUCCESSES else "red"
