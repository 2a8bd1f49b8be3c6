"""The chores of a random library: what a goal says, the programs that bring it about, and tasks of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ntp_dsl.soup.deliveries import Buffer, Job, delivery, freeing, term
from ntp_dsl.soup.draft import Draft, given
from ntp_dsl.soup.errands import Errand, errand
from ntp_dsl.soup.hands import Hand
from ntp_dsl.soup.kinds import Family, Form, Kind, family, kind
from ntp_dsl.soup.lists import GOAL, NUMBERS, Part, Root, number, root
from ntp_dsl.soup.relations import Pair, Relation, relation
from ntp_dsl.soup.scenes import Scene, is_shared

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


# Items to places, one by one --------------------------------------------------------------------


def placing(draft: Draft, tools: Tools) -> TaskWriter:
    """Items go to places of their own or to shared ones, from the table, from elsewhere, or by turns."""
    items = family(draft)
    places = kind(draft, draft.pick((Form.PAD, Form.PAD, Form.TRAY, Form.BIN, Form.BOWL)))
    fact = relation(draft, tools.hand, items, places)
    deliver = delivery(draft, Job(tools.hand, items, places, fact, tools.buffer))
    wish = record(draft, items.root, places.type, swapped=draft.chance(0.4))
    made = chore(draft, tools, _each(draft, wish, fact, deliver))
    source = _source(draft, places, made)
    if draft.chance(0.5):
        _choosing(draft, items, places, fact, deliver)

    def write(draft: Draft) -> None:
        scene = Scene(draft)
        free = made.sides - (isinstance(source, Kind) and source.form.large)
        count = draft.between(3, 4) if places.form is Form.PAD else draft.between(min(2, free), free)
        targets = scene.places(places, count)
        most = count if not is_shared(places.form) else 5
        start, most = _start(scene, source, targets, places, most)
        low = draft.between(min(2, most), min(most, 4))
        group = scene.items(items, low, draft.between(low, min(most, low + 2)), start)
        if len(items.leaves) > 1 and start == "table" and draft.chance(0.4):
            scene.items(items, 1, 2)
        made.task(draft, scene, _goal(draft, wish, group, targets, low, count, places.form))

    return write


def _each(draft: Draft, wish: Record, fact: Relation, deliver: Pair) -> Part:
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
    parameters = f"{element}: {wish.name}" + (f", {limit}: length in 0 .. 1 m" if limit else "")
    return draft.program(parameters, given(item, place), arrived, [deliver(item, place, limit)])


Source = Kind | Family | None  # places or items on which others start; None for the table


def _source(draft: Draft, places: Kind, made: Chore) -> Source:
    """Return what the items start on; the places themselves, if they only change places."""
    if places.form is Form.PAD and draft.chance(0.3):
        return places
    if not draft.chance(0.5):
        return None
    if draft.chance(0.3):
        return family(draft)
    room = made.sides > 2
    return kind(draft, draft.pick((Form.PAD, Form.TRAY, Form.BIN) if room else (Form.PAD,)))


def _start(scene: Scene, source: Source, targets: str, places: Kind, most: int) -> tuple[str, int]:
    """Return where the items start, and how many of them there may be."""
    if source is None:
        return "table", most
    if source is places:
        return targets, most
    if isinstance(source, Family):
        return scene.items(source, 3, 3), min(most, 3)
    if source.form.large:
        return scene.places(source, 1), most
    return scene.places(source, 3), min(most, 3)


def _goal(draft: Draft, wish: Record, group: str, targets: str, items: int, places: int, form: Form) -> str:
    one, other = (targets, group) if wish.swapped else (group, targets)
    most = min(items, places) if wish.swapped or not is_shared(form) else items
    low = draft.between(1, most)
    span = f"{low}..{draft.between(low, most)}"
    result = f"-> list[{wish.name}]"
    if is_shared(form) and not wish.swapped:
        return f"matchings({one}, {other}, pairs={span}) {result}"
    if not wish.swapped and draft.chance(0.6):
        return f"permutations({one}, {other}, length={span}) {result}"
    return f"matchings({one}, {other}, pairs={span}, each=1) {result}"


def _choosing(draft: Draft, items: Family, places: Kind, fact: Relation, deliver: Pair) -> None:
    """Declare programs over records of three objects and a number or a member that decides between two.

    No task runs them: the built-in samplers draw records of two fields.
    """
    name, element, limit = draft.names.type(), draft.names.word(), "5 cm"
    item, one, other, chooser = (draft.names.word() for _ in range(4))
    if items.width:
        kind_of, test = "length", f"{items.width.reading}({element}.{item})"
        bound = f"{element}.{chooser} + {draft.between(1, 3)} cm"
        tests = f"{test} <= {bound}", f"{test} > {bound}"
    else:
        kind_of, members = draft.names.type(), [draft.names.word() for _ in range(2)]
        draft.declare(f"enum {kind_of}: {', '.join(members)}")
        tests = f"{element}.{chooser} == {members[0]}", f"{element}.{chooser} != {members[0]}"
    two_places = f"{one}: {places.type}, {other}: {places.type}"
    draft.declare(f"record {name}({item}: {items.root}, {two_places}, {chooser}: {kind_of})")
    ends = [f"{element}.{field}" for field in (one, other)]
    thing, arrived = f"{element}.{item}", fact.drawn(draft)
    options = [f"({test} and {arrived(thing, end)})" for test, end in zip(tests, ends, strict=True)]
    done = draft.predicate(f"{element}: {name}", f": {' or '.join(options)}")
    calls = [f"when {test}: {deliver(thing, end, limit)}" for test, end in zip(tests, ends, strict=True)]
    choose = draft.program(f"{element}: {name}", given(thing, *ends), f"{done}({element})", calls)
    goal = draft.names.word()
    draft.program(
        f"{goal}: list[{name}]",
        [],
        f"all {done}({element}) for {element} in {goal}",
        [f"for {element} in {goal}: {choose}({element})"],
    )


# Towers -----------------------------------------------------------------------------------------


def stacking(draft: Draft, tools: Tools) -> TaskWriter:
    """Items go on one another; both fields of the record have the same type."""
    items = family(draft)
    places = Kind(items.root, Form.ITEM)
    fact = relation(draft, tools.hand, items, places)
    deliver = delivery(draft, Job(tools.hand, items, places, fact, tools.buffer))
    wish = record(draft, items.root, items.root)
    part = _each(draft, wish, fact, deliver)
    made = chore(draft, tools, part, (Form.TRAY,))  # in a bin, nothing comes to rest on another item

    def write(draft: Draft) -> None:
        scene = Scene(draft)
        leaves = list(items.leaves) if draft.chance(0.5) else [draft.pick(items.leaves)]
        counts = [draft.between(4, 7)] if len(leaves) == 1 else [draft.between(2, 4) for _ in leaves]
        groups = [scene.items(items, n, n, leaf=leaf) for n, leaf in zip(counts, leaves, strict=True)]
        height = draft.between(2, min(4, sum(counts)))
        most = max(n for n in range(1, sum(counts)) if n + -(-n // (min(height, n + 1) - 1)) <= sum(counts))
        span = f"placements=1..{draft.between(1, most)}, height=2..{height}"
        made.task(draft, scene, f"towers({', '.join(groups)}, {span}) -> list[{wish.name}]")

    return write


# By category or by a number ---------------------------------------------------------------------


def sorting(draft: Draft, tools: Tools) -> TaskWriter:
    """All items of a category, or on one side of a limit, go to the place that the goal has for them."""
    graded = draft.chance(0.4)
    items = family(draft, category=not graded, width=graded)
    places = kind(draft, draft.pick((Form.TRAY, Form.BIN)))
    fact = relation(draft, tools.hand, items, places)
    deliver = delivery(draft, Job(tools.hand, items, places, fact, tools.buffer))
    classes, members, test = _grades(draft, items) if graded else _categories(items)
    wish = record(draft, classes, places.type, swapped=draft.chance(0.4))
    evict = None
    if not graded and places.form is Form.TRAY and draft.chance(0.5):
        evict = _evicting(draft, tools.hand, items, places)
    made = chore(draft, tools, _sorted(draft, wish, fact, deliver, items, test, evict))

    def write(draft: Draft) -> None:
        scene = Scene(draft)
        count = draft.between(2, max(2, made.sides))
        targets = scene.places(places, count)
        low = draft.between(members, 5)
        scene.items(items, low, low + draft.between(0, 1))
        one, other = (targets, classes) if wish.swapped else (classes, targets)
        most = min(members, count)
        low = draft.between(1, most)
        span = f"pairs={low}..{draft.between(low, most)}, each=1"
        made.task(draft, scene, f"matchings({one}, {other}, {span}) -> list[{wish.name}]")

    return write


Test = Callable[[str, str, str], str]  # item, class, limit -> condition


def _categories(items: Family) -> tuple[str, int, Test]:
    category = items.category
    assert category is not None
    return category.type, len(category.values), lambda item, each, _: f"{category.reading}({item}) == {each}"


def _grades(draft: Draft, items: Family) -> tuple[str, int, Test]:
    """Declare two grades, and which items have which, given a limit."""
    assert items.width is not None
    name, low, high = draft.names.type(), draft.names.word(), draft.names.word()
    draft.declare(f"enum {name}: {low}, {high}")
    item, grade, limit = (draft.names.word() for _ in range(3))
    width, bound = f"{items.width.reading}({item})", f"{limit} - {draft.between(1, 2)} cm"
    parameters = f"{item}: {items.root}, {grade}: {name}, {limit}: length"
    body = f"({grade} == {low} and {width} <= {bound}) or ({grade} == {high} and not {width} <= {bound})"
    graded = draft.predicate(parameters, f": {body}")
    return name, 2, lambda item, each, limit: f"{graded}({item}, {each}, {limit})"


def _sorted(
    draft: Draft, wish: Record, fact: Relation, deliver: Pair, items: Family, test: Test, evict: str | None
) -> Part:
    """Return the part that loops over a list and, in it, over the items of a type that pass a test."""
    element, item = draft.names.word(), draft.names.word()
    each, place = wish.of(element)
    arrived = fact.drawn(draft)(item, place)
    numbered = deliver.numbered or test("", "", "?").endswith("?)")

    def promise(goal: str, limit: str) -> str:
        return (
            f"all {arrived} for {element} in {goal} for {item} in {items.root} if {test(item, each, limit)}"
        )

    def statements(goal: str, limit: str) -> list[str]:
        call = deliver(item, place, limit)
        first = [f"for {element} in {goal}: {evict}({place}, {each})"] if evict else []
        return [
            *first,
            f"for {element} in {goal}: for {item} in {items.root} if {test(item, each, limit)}: {call}",
        ]

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


# Making room ------------------------------------------------------------------------------------


def vacating(draft: Draft, tools: Tools) -> TaskWriter:
    """Items leave some of the pads for the buffer; the goal is that nothing is there."""
    assert tools.buffer is not None
    items, places = family(draft), kind(draft, Form.PAD)
    mark, members = draft.names.type(), [draft.names.word() for _ in range(draft.between(1, 2))]
    draft.declare(f"enum {mark}: {', '.join(members)}")
    wish = record(draft, places.type, mark)
    job = Job(tools.hand, items, places, relation(draft, tools.hand, items, places), tools.buffer)
    free, element = freeing(draft, job, always_own=True), draft.names.word()
    pad, _ = wish.of(element)
    part = Part(
        GOAL,
        wish.name,
        lambda goal, _: f"all {tools.hand.is_clear}({pad}) for {element} in {goal}",
        lambda goal, _: [f"for {element} in {goal}: {free}({pad})"],
    )
    made = chore(draft, tools, part, puts_down=True)  # a pad is clear as soon as its item is lifted

    def write(draft: Draft) -> None:
        scene = Scene(draft)
        count = draft.between(2, 4)
        pads = scene.places(places, count)
        scene.items(items, count, count, pads)
        low = draft.between(1, count)
        span = f"pairs={low}..{draft.between(low, count)}"
        made.task(draft, scene, f"matchings({pads}, {mark}, {span}) -> list[{wish.name}]")

    return write
