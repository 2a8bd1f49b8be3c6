"""Ways to use the hand: the words of tabletop, or predicates, apis and programs under other names."""

from __future__ import annotations

from dataclasses import dataclass

from ntp_dsl.soup.draft import Draft, given


@dataclass(frozen=True)
class Hand:
    """What the facts of the hand, the apis, and the programs next to them are called."""

    holding: str = "holding"
    empty: str = "empty"
    above: str = "above"
    is_clear: str = "clear"
    covers: str = "covers"
    move: str = "move_to"
    grasp: str = "grasp"
    release: str = "release"
    put_down: str = "put_down"
    clear: str = "clear"
    pick: str = "pick"


TABLETOP = Hand()
PARAMETERS = {  # of the facts that may have another name
    "holding": ("Object",),
    "empty": ("Gripper",),
    "above": ("Gripper", "Place"),
    "clear": ("Place",),
    "covers": ("Object", "Place"),
}
RENAMED = 0.5  # of these facts, in a hand of the library's own


def own_hand(draft: Draft) -> Hand:
    """Declare apis of other names, the programs that call them, and perhaps other names for the facts."""
    facts = {fact: _renamed(fact, draft) for fact in PARAMETERS}
    hand = Hand(
        facts["holding"],
        facts["empty"],
        facts["above"],
        facts["clear"],
        facts["covers"],
        *(draft.names.word() for _ in range(6)),
    )
    place, thing = draft.names.word(), draft.names.word()
    draft.declare(
        f"api {hand.move}({place}: Place) by move_to\n"
        f"    requires present({place}) and reachable({place})\n"
        f"    achieves {hand.above}(gripper, {place})"
    )
    needed = draft.shuffled(
        [
            f"{hand.above}(gripper, {thing})",
            f"reachable({thing})",
            f"{hand.is_clear}({thing})",
            f"{hand.empty}(gripper)",
        ]
    )
    draft.declare(
        f"api {hand.grasp}({thing}: Object) by grasp\n"
        f"    requires {' and '.join(needed)}\n"
        f"    achieves {hand.holding}({thing})"
    )
    draft.declare(
        f"api {hand.release}() by release\n"
        f"    requires {hand.holding}(any)\n"
        f"    achieves {hand.empty}(gripper)"
    )
    _write_programs(draft, hand)
    return hand


def _renamed(fact: str, draft: Draft) -> str:
    if not draft.chance(RENAMED):
        return fact
    parameters = ", ".join(f"{draft.names.word()}: {kind}" for kind in PARAMETERS[fact])
    return draft.predicate(parameters, f" by {fact}")


def _write_programs(draft: Draft, hand: Hand) -> None:
    draft.program(
        "",
        [f"{hand.holding}(any)"],
        f"{hand.empty}(gripper)",
        [f"{hand.move}(table)", f"{hand.release}()"],
        hand.put_down,
    )
    place, other = draft.names.word(), draft.names.word()
    draft.program(
        f"{place}: Place",
        [],
        f"{hand.is_clear}({place})",
        [f"for {other} in Object if {hand.covers}({other}, {place}): {hand.pick}({other})"],
        hand.clear,
    )
    getting(draft, hand, "Object", hand.pick)


def getting(draft: Draft, hand: Hand, kind: str, name: str | None = None) -> str:
    """Declare a program that gets an object of a type into the hand, and return its name."""
    thing = draft.names.word()
    free = draft.shuffled([f"{hand.put_down}()", f"{hand.clear}({thing})"])
    body = [*free, f"{hand.move}({thing})", f"{hand.grasp}({thing})"]
    if draft.chance(0.3):
        body = [f"{hand.put_down}()", f"{_approach(draft, hand, kind)}({thing})", f"{hand.grasp}({thing})"]
    return draft.program(f"{thing}: {kind}", given(thing), f"{hand.holding}({thing})", body, name)


def _approach(draft: Draft, hand: Hand, kind: str) -> str:
    """Declare a program that clears an object and brings the hand over it."""
    thing = draft.names.word()
    return draft.program(
        f"{thing}: {kind}",
        given(thing),
        f"{hand.is_clear}({thing}) and {hand.above}(gripper, {thing})",
        [f"{hand.clear}({thing})", f"{hand.move}({thing})"],
    )
