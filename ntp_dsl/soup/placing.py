"""Items go to places, one by one: from the table, from elsewhere, or by changing places."""

from __future__ import annotations

from ntp_dsl.soup.choosing import choosing
from ntp_dsl.soup.chores import Chore, Record, TaskWriter, Tools, chore, every_element, record
from ntp_dsl.soup.deliveries import Job, delivery
from ntp_dsl.soup.draft import Draft
from ntp_dsl.soup.kinds import Family, Form, Kind, family, kind
from ntp_dsl.soup.relations import relation
from ntp_dsl.soup.scenes import Scene

Source = Kind | Family | None  # places or items on which others start; None for the table


def placing(draft: Draft, tools: Tools) -> TaskWriter:
    """Declare items, places for one or for several, and programs that bring the ones to the others."""
    items = family(draft)
    places = kind(draft, draft.pick((Form.PAD, Form.PAD, Form.TRAY, Form.BIN, Form.BOWL)))
    fact = relation(draft, tools.hand, items, places)
    deliver = delivery(draft, Job(tools.hand, items, places, fact, tools.buffer))
    wish = record(draft, items.root, places.type, swapped=draft.chance(0.4))
    made = chore(draft, tools, every_element(draft, wish, fact, deliver))
    source = _source(draft, places, made)
    if draft.chance(0.5):
        choosing(draft, items, places, fact, deliver)

    def write(draft: Draft) -> None:
        scene = Scene(draft)
        free = made.sides - (isinstance(source, Kind) and source.form.large)
        count = draft.between(3, 4) if places.form is Form.PAD else draft.between(min(2, free), free)
        targets = scene.places(places, count)
        most = count if not places.form.shared else 5
        start, most = _start(scene, source, targets, places, most)
        low = draft.between(min(2, most), min(most, 4))
        group = scene.items(items, low, draft.between(low, min(most, low + 2)), start)
        if len(items.leaves) > 1 and start == "table" and draft.chance(0.4):
            scene.items(items, 1, 2)
        made.task(draft, scene, _goal(draft, wish, group, targets, low, count, places.form))

    return write


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
    return scene.places(source, 1 if source.form.large else 3), min(most, 3)


def _goal(draft: Draft, wish: Record, group: str, targets: str, items: int, places: int, form: Form) -> str:
    one, other = (targets, group) if wish.swapped else (group, targets)
    most = min(items, places) if wish.swapped or not form.shared else items
    low = draft.between(1, most)
    span = f"{low}..{draft.between(low, most)}"
    result = f"-> list[{wish.name}]"
    if form.shared and not wish.swapped:
        return f"matchings({one}, {other}, pairs={span}) {result}"
    if not wish.swapped and draft.chance(0.6):
        return f"permutations({one}, {other}, length={span}) {result}"
    return f"matchings({one}, {other}, pairs={span}, each=1) {result}"
