"""Numbers are copied: from what a program was given, or from what the demonstration shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from ntp_dsl.core.per_library import batches
from ntp_dsl.core.per_library.config import CoreConfig
from ntp_dsl.core.per_library.features import LENGTHS
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.core.per_library.model import Core, Hint
from ntp_dsl.demonstrations.demonstration import Demonstration
from ntp_dsl.demonstrations.queries import Query
from ntp_dsl.language.loader import load
from ntp_dsl.semantics.observation import Observation, SceneObject

LIBRARY = """library mine
use tabletop
enum Side: left, right

api shift(side: Side, mark: Movable, distance: length in 8 cm .. 24 cm) by python
    requires holding(any)
    achieves above(gripper, mark)

program bring(mark: Movable, distance: length in 0 cm .. 1 m, side: Side):
    requires present(mark) and reachable(mark) and holding(any)
    achieves above(gripper, mark)
    shift(side, mark, distance)
"""
# Among the weights: the free one, two given, and as many as there are lengths in each of two hops, …
GIVEN, BACK_ALONG_Y = 1, 3 + 2 * LENGTHS + 4


@pytest.mark.parametrize(("source", "number"), [(GIVEN, 0.137), (BACK_ALONG_Y, 0.162)])
def test_a_number_is_copied_exactly(source: int, number: float, tmp_path: Path) -> None:
    path = tmp_path / "mine.ntp"
    path.write_text(LIBRARY)
    memory = Memory.of(load(path))
    core = Core(CoreConfig(), memory)
    cube = (0.05, 0.05, 0.05)
    objects = tuple(SceneObject(name, "Block", cube) for name in ("one", "other"))
    seen = Observation(objects, {"one": (0.4, 0.0, 0.025), "other": (0.6, 0.1, 0.025)}, (0.5, 0, 0.3), False)
    nothing = Demonstration(objects, np.zeros(1), np.zeros(1), np.zeros((1, 3)), np.zeros((1, 2, 3)))
    states = batches.states(memory, [Query("bring", ("one", 0.137, "left"), (0, 1), seen, nothing)], [0])
    points = torch.tensor([[[0.1, 0.0, -0.1], [0.3, -0.162, -0.1]]])
    hint = Hint(
        torch.zeros(1, 2, 2), torch.zeros(1), torch.ones(1), torch.zeros(1, core.reader.relations), points
    )
    thought = core.consider(states, hint)
    with torch.no_grad():  # as one that has learnt where the number comes from
        last = core.values.answer[-1]
        last.weight.zero_()
        last.bias.zero_()
        signature = memory.signature("shift")
        place = next(n for n, value in enumerate(signature.values) if not value.members)
        row = last.bias.view(memory.value_arity, -1)[place]
        row[memory.choices + source] = 100.0
        _, numbers = core.evaluate(thought, states, hint, torch.tensor([0]))
    value = signature.values[place]
    assert value.number(float(numbers[0, place])) == pytest.approx(number, abs=1e-6)
