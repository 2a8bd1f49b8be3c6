"""Records of three objects, and a number or a member that decides between two of them."""

from __future__ import annotations

from ntp_dsl.soup.draft import Draft, given
from ntp_dsl.soup.kinds import Family, Kind
from ntp_dsl.soup.relations import Pair, Relation


def choosing(draft: Draft, items: Family, places: Kind, fact: Relation, deliver: Pair) -> None:
    """Declare programs over such records: each item goes to one of its two places.

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
