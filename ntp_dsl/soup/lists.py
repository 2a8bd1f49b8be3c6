"""Programs over lists, which tasks run: loops over a goal, over groups of the scene and over its objects."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ntp_dsl.soup.deliveries import NUMBER
from ntp_dsl.soup.draft import Draft
from ntp_dsl.soup.hands import Hand

GOAL, NUMBERS = "goal", "number"  # the lists of a call that a task draws, and its number
WRAPPED = 0.3  # of the programs, in another one over the same lists


@dataclass(frozen=True)
class Part:
    """One thing that a program over lists does.

    `promise` and `statements` take the name of a list, which is empty without `list_of`, and a number.
    """

    key: str
    list_of: str
    promise: Callable[[str, str], str]
    statements: Callable[[str, str], list[str]]
    numbered: bool = False


@dataclass(frozen=True)
class Root:
    """A program that a task runs."""

    name: str
    arguments: tuple[str, ...]  # the keys of the parts whose lists it takes, and of the number
    parts: tuple[Part, ...]
    ending: str = ""  # what else it promises

    def call(self, values: Mapping[str, str]) -> str:
        return f"{self.name}({', '.join(values[key] for key in self.arguments)})"

    def promise(self, values: Mapping[str, str]) -> str:
        number = values.get(NUMBERS, "")
        promises = [part.promise(values.get(part.key, ""), number) for part in self.parts]
        promises += [self.ending] if self.ending else []
        return promises[0] if len(promises) == 1 else " and ".join(f"({each})" for each in promises)


def root(draft: Draft, hand: Hand, parts: list[Part], puts_down: bool) -> Root:
    """Declare a program that does all parts, perhaps below one that only calls it.

    Below two such programs an expert would go round in circles where an object is missing: a call is only
    left out where the callee's own first step is a return.
    """
    shuffled = tuple(draft.shuffled(parts))
    ending = f"{hand.empty}(gripper)" if puts_down else ""
    made = Root("", _arguments(draft, shuffled), shuffled, ending)
    names = {key: draft.names.word() for key in made.arguments}
    body = [
        row for part in shuffled for row in part.statements(names.get(part.key, ""), names.get(NUMBERS, ""))
    ]
    made = _declared(draft, made, names, body + ([f"{hand.put_down}()"] if puts_down else []))
    return _wrapper(draft, made) if draft.chance(WRAPPED) else made


def _arguments(draft: Draft, parts: tuple[Part, ...]) -> tuple[str, ...]:
    keys = [part.key for part in parts if part.list_of]
    keys += [NUMBERS] if any(part.numbered for part in parts) else []
    return tuple(draft.shuffled(keys))


def _declared(draft: Draft, made: Root, names: Mapping[str, str], body: list[str]) -> Root:
    types = {part.key: f"list[{part.list_of}]" for part in made.parts} | {NUMBERS: NUMBER}
    parameters = ", ".join(f"{names[key]}: {types[key]}" for key in made.arguments)
    name = draft.program(parameters, [], made.promise(names), body)
    return Root(name, made.arguments, made.parts, made.ending)


def _wrapper(draft: Draft, inner: Root) -> Root:
    names = {key: draft.names.word() for key in inner.arguments}
    outer = Root("", tuple(draft.shuffled(inner.arguments)), inner.parts, inner.ending)
    return _declared(draft, outer, names, [inner.call(names)])


def number(draft: Draft) -> str:
    """Return a number that a task passes to its program."""
    return f"{draft.between(3, 9)} cm"
