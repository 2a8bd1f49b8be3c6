"""The call tree as it unfolds, a line a call."""

from __future__ import annotations

from typing import Any

from rich.text import Text

from ntp_dsl.cli.display import answers
from ntp_dsl.language.registry import Registry
from ntp_dsl.semantics.observation import Argument

FINE = ("done", "achieved")


class LiveTree:
    """A watcher of the interpreter that prints programs as they are called and primitives as they end."""

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self._rooted = False

    def __call__(
        self, event: str, depth: int, name: str, arguments: tuple[Argument, ...], detail: Any
    ) -> None:
        is_api = name in self._registry.apis
        shown = ", ".join(argument for argument in arguments if isinstance(argument, str))
        line = Text("  " * depth + f"{name}({shown})", style="" if is_api else "bold")
        if event == "call":
            if is_api or depth == 0 and self._rooted:
                return  # a root that is asked again, to confirm that all is done, is shown once
            self._rooted = True
            if detail is not None:
                line.append(f"  frames {detail[0]}–{detail[1]}", style="dim")
        elif is_api:
            line.append("  ✓" if detail in FINE else f"  ✗ {detail}", style=_colour(detail))
        elif detail in FINE:
            return
        else:
            line.append(f"  {detail}", style="yellow")
        answers.print(line)


def _colour(outcome: str) -> str:
    return "green" if outcome in FINE else "red"
