"""Of a demonstration enough is read to tell its calls apart."""

from __future__ import annotations

import numpy as np
import pytest

from ntp_dsl.core.per_library import keyframes
from ntp_dsl.datasets.recording import RecordedDemonstration, demonstrate
from ntp_dsl.policies.expert import Expert
from ntp_dsl.tasks.instances import draw, find_task
from ntp_dsl.user_code.loading import load_with_python
from ntp_dsl.worlds.catalogue import make_world


@pytest.mark.parametrize("example", ["block_stacking", "table_cleanup", "set_the_table"])
def test_each_call_has_frames_of_its_own_from_the_end_of_the_one_before(example: str) -> None:
    registry = load_with_python(example)
    world = make_world("kinematic", registry)
    for seed in range(5):
        instance = draw(registry, find_task(registry, example), np.random.default_rng(seed))
        shown = demonstrate(registry, Expert(registry), world, instance, seed)
        assert isinstance(shown, RecordedDemonstration) and shown.calls is not None
        for call in shown.calls.walk():
            kept = keyframes.within(shown.demonstration, call.scope)
            for child in (each for each in call.children if each.name in registry.programs):
                before, last = (keyframes.last_before(kept, frame) for frame in child.scope)
                assert before < last, (seed, child.name, child.scope)
                assert all(child.scope[0] <= frame < child.scope[1] for frame in kept[before + 1 : last + 1])
