"""What a world notes of an attempt, where a library asks how often something has failed."""

from __future__ import annotations

from collections.abc import Sequence

from ntp_dsl.semantics.attempts import after_attempt
from ntp_dsl.semantics.observation import Argument, without_lists
from ntp_dsl.worlds.protocol import Outcome, World


def note_attempt(world: World, api: str, arguments: Sequence[Argument], outcome: Outcome) -> None:
    """Count a call that failed, or begin anew, for the objects among its arguments and in their records."""
    objects = {each for each in without_lists(tuple(arguments)) if isinstance(each, str)}
    if outcome.achieved or outcome.is_failed_attempt:
        known = objects & world.truth().by_name.keys()
        world.facts = after_attempt(world.facts, api, known, outcome.achieved)
