"""From a seed to a random library: one to three chores, a hand or two, and tasks of each chore."""

from __future__ import annotations

from random import Random

from ntp_dsl.language.formatting.canonical import format_text
from ntp_dsl.soup.chores import TaskWriter, Tools
from ntp_dsl.soup.deliveries import buffer
from ntp_dsl.soup.draft import Draft
from ntp_dsl.soup.hands import TABLETOP, own_hand
from ntp_dsl.soup.names import Names
from ntp_dsl.soup.placing import placing
from ntp_dsl.soup.sorting import sorting
from ntp_dsl.soup.stacking import stacking
from ntp_dsl.soup.vacating import vacating

CHORES = (placing, placing, sorting, stacking)  # placing is the most varied


def library_name(seed: int) -> str:
    """Return what the library of a seed is called."""
    return f"soup_{seed}"


def random_library(seed: int) -> str:
    """Return the text of a random library, `library soup_SEED`, in canonical layout.

    It is sound by construction, and has no Python: its goals are drawn by the built-in samplers.
    """
    return written(seed, Names(Random(f"names of soup {seed}")))


def written(seed: int, names: Names) -> str:
    """Return the library of a seed with names of another source; for tests."""
    draft = Draft(Random(f"soup {seed}"), names)
    for write in _chores(draft):
        for _ in range(draft.between(1, 2)):
            write(draft)
    return format_text(draft.text(library_name(seed)))


def _chores(draft: Draft) -> list[TaskWriter]:
    hands = [own_hand(draft) if draft.chance(0.5) else TABLETOP]
    if draft.chance(0.3):
        hands.append(own_hand(draft))
    tools = [Tools(hand, buffer(draft, hand) if draft.chance(0.5) else None) for hand in hands]
    chores = []
    for _ in range(draft.between(1, 3)):
        chosen = draft.pick(tools)
        may_vacate = chosen.buffer is not None and draft.chance(0.3)
        make = vacating if may_vacate else draft.pick(CHORES)
        chores.append(make(draft, chosen))
    return chores
