"""Items leave some of the pads for the buffer; the goal is that nothing is there."""

from __future__ import annotations

from ntp_dsl.soup.chores import TaskWriter, Tools, chore, record
from ntp_dsl.soup.deliveries import Job, freeing
from ntp_dsl.soup.draft import Draft
from ntp_dsl.soup.kinds import Form, family, kind
from ntp_dsl.soup.lists import GOAL, Part
from ntp_dsl.soup.relations import relation
from ntp_dsl.soup.scenes import Scene


def vacating(draft: Draft, tools: Tools) -> TaskWriter:
    """Declare pads, items on them, and programs that clear the pads of a goal."""
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
