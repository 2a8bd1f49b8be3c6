"""What the chores of a random library share: a record, a program over a list of it, and tasks that run it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ntp_dsl.soup.deliveries import NUMBER, Buffer, term
from ntp_dsl.soup.draft import Draft, given
from ntp_dsl.soup.errands import Errand, errand
from ntp_dsl.soup.hands import Hand
from ntp_dsl.soup.kinds import Form
from ntp_dsl.soup.lists import GOAL, NUMBERS, Part, Root, number, root
from ntp_dsl.soup.relations import Pair, Relation
from ntp_dsl.soup.scenes import Scene

TaskWriter = Callable[[Draft], None]


@dataclass(frozen=True)
class Tools:
    """What the chores of a library share."""

    hand: Hand
    buffer: Buffer | None


@dataclass(frozen=True)
class Record:
    """A record of two fields, by what they mean."""

    name: str
    first: str  # field
    second: str
    swapped: bool  # the second means what comes first elsewhere

    def of(self, element: str) -> tuple[str, str]:
        """Return the two fields of an element, in the order of their meaning."""
        fields = f"{element}.{self.first}", f"{element}.{self.second}"
        return (fields[1], fields[0]) if self.swapped else fields


def record(draft: Draft, one: str, other: str, swapped: bool = False) -> Record:
    """Declare a record of two types."""
    name, first, second = draft.names.type(), draft.names.word(), draft.names.word()
    types = (other, one) if swapped else (one, other)
    draft.declare(f"record {name}({first}: {types[0]}, {second}: {types[1]})")
    return Record(name, first, second, swapped)


@dataclass(frozen=True)
class Chore:
    """A program over a goal, perhaps with an errand, and how to prepare a scene for it."""

    root: Root
    tools: Tools
    errand: Errand | None

    def task(self, draft: Draft, scene: Scene, goal: str) -> None:
        """Declare a task over the groups of a scene, with a sampler of its goal."""
        values = {GOAL: "goal", NUMBERS: number(draft)}
        if self.tools.buffer:
            scene.places(self.tools.buffer.places, 1)
        if self.errand:
            values |= self.errand.prepare(scene, draft)
        scene.bystanders()
        rows = "\n        ".join(scene.rows)
        draft.declare(
            f"task {draft.names.word()}:\n    scene:\n        {rows}\n    goal: {goal}\n"
            f"    run: {self.root.call(values)}\n    success: {self.root.promise(values)}"
        )

    @property
    def sides(self) -> int:
        """Return how many sides of the table are free for the chore's own places."""
        return 4 - (self.tools.buffer is not None) - (self.errand is not None)


def chore(
    draft: Draft,
    tools: Tools,
    part: Part,
    forms: Sequence[Form] = (Form.TRAY, Form.BIN),
    puts_down: bool = False,
) -> Chore:
    """Declare the program of a part that is about the goal, and perhaps of an errand.

    Args:
        forms: of the place where an errand may bring its items.
        puts_down: whether the program has to promise that the hand is empty.
    """
    extra = errand(draft, tools.hand, tools.buffer, forms) if draft.chance(0.3) else None
    parts = [part, extra.part] if extra else [part]
    return Chore(root(draft, tools.hand, parts, puts_down or draft.chance(0.25)), tools, extra)


def every_element(draft: Draft, wish: Record, fact: Relation, deliver: Pair) -> Part:
    """Return the part that brings every item of a list to its place, by its fields or as a whole record."""
    element = draft.names.word()
    item, place = wish.of(element)
    arrived = fact.drawn(draft)(item, place)
    if draft.chance(0.3):
        arrived = f"{_granted(draft, wish, fact)}({element})"
    whole = _granting(draft, wish, arrived, element, deliver) if draft.chance(0.3) else None

    def promise(goal: str, limit: str) -> str:
        return f"all {arrived} for {element} in {goal}"

    def statements(goal: str, limit: str) -> list[str]:
        more = f", {limit}" if deliver.numbered else ""
        call = f"{whole}({element}{more})" if whole else deliver(item, place, limit and term(draft, limit))
        return [f"for {element} in {goal}: {call}"]

    return Part(GOAL, wish.name, promise, statements, deliver.numbered)


def _granted(draft: Draft, wish: Record, fact: Relation) -> str:
    """Declare that an element of the goal is fulfilled, as a predicate of the record."""
    element = draft.names.word()
    return draft.predicate(f"{element}: {wish.name}", f": {fact.drawn(draft)(*wish.of(element))}")


def _granting(draft: Draft, wish: Record, arrived: str, element: str, deliver: Pair) -> str:
    """Declare a program that fulfils an element, given as a whole record."""
    item, place = wish.of(element)
    limit = draft.names.word() if deliver.numbered else ""
    parameters = f"{element}: {wish.name}" + (f", {limit}: {NUMBER}" if limit else "")
    return draft.program(parameters, given(item, place), arrived, [deliver(item, place, limit)])
