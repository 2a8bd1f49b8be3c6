"""Items go on one another, in towers; both fields of the record have the same type."""

from __future__ import annotations

from ntp_dsl.language.names.samplers import blocks_needed
from ntp_dsl.soup.chores import TaskWriter, Tools, chore, every_element, record
from ntp_dsl.soup.deliveries import Job, delivery
from ntp_dsl.soup.draft import Draft
from ntp_dsl.soup.kinds import Form, Kind, family
from ntp_dsl.soup.relations import relation
from ntp_dsl.soup.scenes import Scene


def stacking(draft: Draft, tools: Tools) -> TaskWriter:
    """Declare items, and programs that build towers of them."""
    items = family(draft)
    places = Kind(items.root, Form.ITEM)
    fact = relation(draft, tools.hand, items, places)
    deliver = delivery(draft, Job(tools.hand, items, places, fact, tools.buffer))
    wish = record(draft, items.root, items.root)
    part = every_element(draft, wish, fact, deliver)
    made = chore(draft, tools, part, (Form.TRAY,))  # in a bin, nothing comes to rest on another item

    def write(draft: Draft) -> None:
        scene = Scene(draft)
        leaves = list(items.leaves) if draft.chance(0.5) else [draft.pick(items.leaves)]
        counts = [draft.between(4, 7)] if len(leaves) == 1 else [draft.between(2, 4) for _ in leaves]
        groups = [scene.items(items, n, n, leaf=leaf) for n, leaf in zip(counts, leaves, strict=True)]
        height = draft.between(2, min(4, sum(counts)))
        most = max(n for n in range(1, sum(counts)) if blocks_needed(n, min(height, n + 1)) <= sum(counts))
        span = f"placements=1..{draft.between(1, most)}, height=2..{height}"
        made.task(draft, scene, f"towers({', '.join(groups)}, {span}) -> list[{wish.name}]")

    return write
