"""All items of a category, or on one side of a limit, go to the place that the goal has for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ntp_dsl.soup.chores import Record, TaskWriter, Tools, chore, record
from ntp_dsl.soup.deliveries import Job, delivery
from ntp_dsl.soup.draft import Draft
from ntp_dsl.soup.hands import Hand
from ntp_dsl.soup.kinds import Family, Form, Kind, family, kind
from ntp_dsl.soup.lists import GOAL, Part
from ntp_dsl.soup.relations import Pair, Relation, relation
from ntp_dsl.soup.scenes import Scene


def sorting(draft: Draft, tools: Tools) -> TaskWriter:
    """Declare items, and programs that bring all of a class to the place that the goal has for it."""
    graded = draft.chance(0.4)
    items = family(draft, category=not graded, width=graded)
    places = kind(draft, draft.pick((Form.TRAY, Form.BIN)))
    fact = relation(draft, tools.hand, items, places)
    deliver = delivery(draft, Job(tools.hand, items, places, fact, tools.buffer))
    classes = _grades(draft, items) if graded else _categories(items)
    wish = record(draft, classes.type, places.type, swapped=draft.chance(0.4))
    evict = None
    if not graded and places.form is Form.TRAY and draft.chance(0.5):
        evict = _evicting(draft, tools.hand, items, places)
    made = chore(draft, tools, _sorted(draft, wish, fact, deliver, items, classes, evict))

    def write(draft: Draft) -> None:
        scene = Scene(draft)
        count = draft.between(2, max(2, made.sides))
        targets = scene.places(places, count)
        low = draft.between(classes.count, 5)
        scene.items(items, low, low + draft.between(0, 1))
        one, other = (targets, classes.type) if wish.swapped else (classes.type, targets)
        most = min(classes.count, count)
        low = draft.between(1, most)
        span = f"pairs={low}..{draft.between(low, most)}, each=1"
        made.task(draft, scene, f"matchings({one}, {other}, {span}) -> list[{wish.name}]")

    return write


@dataclass(frozen=True)
class Classes:
    """An enumeration by which items are told apart, and the test for an item, a member and a limit."""

    type: str
    count: int
    test: Callable[[str, str, str], str]
    numbered: bool = False


def _categories(items: Family) -> Classes:
    category = items.category
    assert category is not None
    return Classes(
        category.type, len(category.values), lambda item, each, _: f"{category.reading}({item}) == {each}"
    )


def _grades(draft: Draft, items: Family) -> Classes:
    """Declare two grades, and which items have which, given a limit."""
    assert items.width is not None
    name, low, high = draft.names.type(), draft.names.word(), draft.names.word()
    draft.declare(f"enum {name}: {low}, {high}")
    item, grade, limit = (draft.names.word() for _ in range(3))
    width, bound = f"{items.width.reading}({item})", f"{limit} - {draft.between(1, 2)} cm"
    parameters = f"{item}: {items.root}, {grade}: {name}, {limit}: length"
    body = f"({grade} == {low} and {width} <= {bound}) or ({grade} == {high} and not {width} <= {bound})"
    graded = draft.predicate(parameters, f": {body}")
    return Classes(name, 2, lambda item, each, limit: f"{graded}({item}, {each}, {limit})", numbered=True)


def _sorted(
    draft: Draft,
    wish: Record,
    fact: Relation,
    deliver: Pair,
    items: Family,
    classes: Classes,
    evict: str | None,
) -> Part:
    """Return the part that loops over a list and, in it, over the items of a type that pass a test."""
    element, item = draft.names.word(), draft.names.word()
    each, place = wish.of(element)
    arrived = fact.drawn(draft)(item, place)
    numbered = deliver.numbered or classes.numbered

    def elements(goal: str, limit: str) -> tuple[str, str]:
        test = classes.test(item, each, limit)
        return f"for {element} in {goal}", f"for {item} in {items.root} if {test}"

    def promise(goal: str, limit: str) -> str:
        return " ".join([f"all {arrived}", *elements(goal, limit)])

    def statements(goal: str, limit: str) -> list[str]:
        outer, inner = elements(goal, limit)
        first = [f"{outer}: {evict}({place}, {each})"] if evict else []
        return [*first, f"{outer}: {inner}: {deliver(item, place, limit)}"]

    return Part(GOAL, wish.name, promise, statements, numbered)


def _evicting(draft: Draft, hand: Hand, items: Family, places: Kind) -> str:
    """Declare a program that takes the items of other categories off a tray."""
    tray, item, each = (draft.names.word() for _ in range(3))
    assert items.category is not None
    reading = f"{items.category.reading}({item})"
    return draft.program(
        f"{tray}: {places.type}, {each}: {items.category.type}",
        [],
        f"all {reading} == {each} for {item} in {items.root} if on({item}, {tray})",
        [f"for {item} in {items.root} if on({item}, {tray}) and {reading} != {each}: {hand.pick}({item})"],
    )
