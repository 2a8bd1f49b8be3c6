"""Programs that bring an item to a place: two to six levels of free, get, leave, carry and deliver."""

from __future__ import annotations

from dataclasses import dataclass

from ntp_dsl.soup.draft import Draft, given
from ntp_dsl.soup.hands import Hand, getting
from ntp_dsl.soup.kinds import Family, Form, Kind
from ntp_dsl.soup.relations import Pair, Relation, ordered

NUMBER = "length in 0 .. 1 m"  # of a limit that calls hand on
WRAPPED = 0.35  # of deliveries, in a program that calls them
MOST_WRAPPERS = 2


@dataclass(frozen=True)
class Buffer:
    """A tray for what is in the way, and the program that brings anything there."""

    places: Kind
    deliver: Pair


@dataclass(frozen=True)
class Job:
    """What is to be brought where, what it means that it is there, and by which hand."""

    hand: Hand
    items: Family
    places: Kind
    relation: Relation
    buffer: Buffer | None = None


def delivery(draft: Draft, job: Job) -> Pair:
    """Declare a program that brings an item to a place, with all that it calls."""
    deliver = _deliver(draft, job)
    for _ in range(MOST_WRAPPERS):
        if draft.chance(WRAPPED):
            deliver = _wrapper(draft, job, deliver)
    return deliver


def buffer(draft: Draft, hand: Hand) -> Buffer:
    """Declare a tray for anything, and the program that brings it there."""
    places = Kind(draft.type("Place"), Form.TRAY)
    job = Job(hand, Family("Movable", ("Movable",)), places, Relation((Pair("on"),)))
    return Buffer(places, _deliver(draft, job))


@dataclass(frozen=True)
class _Frame:
    """The names of a program's parameters, and how it is declared with them."""

    draft: Draft
    job: Job
    item: str
    place: str
    parameters: str
    place_first: bool

    @classmethod
    def of(cls, draft: Draft, job: Job) -> _Frame:
        """Return new names for the parameters of a job's program, in a random order."""
        item, place = draft.names.word(), draft.names.word()
        return cls(draft, job, item, place, *ordered(draft, item, job.items.root, place, job.places.type))

    def declare(self, requires: list[str], body: list[str], number: str = "") -> Pair:
        """Declare a program that achieves the job's relation."""
        fact = self.job.relation.drawn(self.draft)(self.item, self.place)
        parameters = self.parameters + (f", {number}: {NUMBER}" if number else "")
        name = self.draft.program(parameters, requires, fact, body)
        return Pair(name, self.place_first, bool(number))


def _deliver(draft: Draft, job: Job) -> Pair:
    """Declare the program that frees the place and carries the item there, in one way or by a reading."""
    frame = _Frame.of(draft, job)
    item, place = frame.item, frame.place
    needs_room = not job.places.form.large or draft.chance(0.5)
    body = [_freed(draft, job, place)] if needs_room else []
    number = ""
    if job.items.traits and draft.chance(0.4):
        number = draft.names.word() if job.items.width and draft.chance(0.6) else ""
        body += _by_reading(draft, job, frame, number, needs_room)
    elif draft.chance(0.4):
        body.append(_carry(draft, job, needs_room)(item, place))
    else:
        body.append(f"{_get(draft, job)}({item})")
        body.append(_leave(draft, job, needs_room)(item, place))
    return frame.declare(given(item, place), body, number)


def _by_reading(draft: Draft, job: Job, frame: _Frame, number: str, needs_room: bool) -> list[str]:
    """Return two calls, one for each outcome of a test of the item."""
    if number:
        assert job.items.width is not None
        width, limit = f"{job.items.width.reading}({frame.item})", term(draft, number)
        tests = f"{width} <= {limit}", f"{width} > {limit}"
    else:
        tests = draft.pick(job.items.traits).test(draft, frame.item)
    ways = [_carry(draft, job, needs_room) for _ in tests]
    return [f"when {test}: {way(frame.item, frame.place)}" for test, way in zip(tests, ways, strict=True)]


def term(draft: Draft, number: str) -> str:
    """Return a term of a number that is handed on."""
    more = f"{draft.between(1, 3)} cm"
    return draft.pick((number, f"{number} + {more}", f"{number} / 2 + {more}", f"2 * {number} - {more}"))


def _wrapper(draft: Draft, job: Job, inner: Pair) -> Pair:
    """Declare a program that calls another one, perhaps with its arguments in another order."""
    frame = _Frame.of(draft, job)
    number = draft.names.word() if inner.numbered else ""
    passed = f"{number} / 2 + 1 cm" if number and draft.chance(0.3) else number
    return frame.declare(given(frame.item, frame.place), [inner(frame.item, frame.place, passed)], number)


def _carry(draft: Draft, job: Job, needs_room: bool) -> Pair:
    """Declare a program that gets the item and leaves it at a place that is free."""
    frame = _Frame.of(draft, job)
    body = [
        f"{_get(draft, job)}({frame.item})",
        _leave(draft, job, needs_room)(frame.item, frame.place),
    ]
    return frame.declare([*given(frame.item, frame.place), *_room(job, frame.place, needs_room)], body)


def _room(job: Job, place: str, needed: bool) -> list[str]:
    return [f"{job.hand.is_clear}({place})"] if needed else []


def _get(draft: Draft, job: Job) -> str:
    """Return a program that gets an item into the hand: the hand's own, or another one."""
    if draft.chance(0.5):
        return job.hand.pick
    if draft.chance(0.6):
        return getting(draft, job.hand, job.items.root)
    item = draft.names.word()
    fact = f"{job.hand.holding}({item})"
    return draft.program(f"{item}: {job.items.root}", given(item), fact, [f"{job.hand.pick}({item})"])


def _leave(draft: Draft, job: Job, needs_room: bool) -> Pair:
    """Declare a program that lets go of the item at the place."""
    frame, hand = _Frame.of(draft, job), job.hand
    holding = f"{hand.holding}({frame.item})"
    move = f"{hand.move}({frame.place})"
    if draft.chance(0.25):
        over = _Frame.of(draft, job)
        name = draft.program(
            over.parameters,
            [f"{hand.holding}({over.item})", *given(over.place)],
            f"{hand.above}(gripper, {over.place})",
            [f"{hand.move}({over.place})"],
        )
        move = Pair(name, over.place_first)(frame.item, frame.place)
    requires = [holding, *_room(job, frame.place, needs_room), *given(frame.place)]
    return frame.declare(requires, [move, f"{hand.release}()"])


def _freed(draft: Draft, job: Job, place: str) -> str:
    """Return a statement that frees the place of what is on it."""
    call = f"{freeing(draft, job)}({place})"
    return f"when not {job.hand.is_clear}({place}): {call}" if draft.chance(0.2) else call


def freeing(draft: Draft, job: Job, always_own: bool = False) -> str:
    """Return a program that frees a place: the hand's own, or one that takes things to the buffer."""
    hand = job.hand
    if job.buffer is None or not (always_own or draft.chance(0.7)):
        return hand.clear
    place, other, tray = (draft.names.word() for _ in range(3))
    aside = job.buffer.deliver(other, tray)
    return draft.program(
        f"{place}: {job.places.type}",
        given(place),
        f"{hand.is_clear}({place})",
        [
            f"for {other} in Movable if {hand.covers}({other}, {place}): "
            f"for {tray} in {job.buffer.places.type}: {aside}"
        ],
    )
