"""What a user brings to the worlds is told what it lacks."""

from __future__ import annotations

import pytest

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load
from ntp_dsl.worlds.catalogue import equip
from ntp_dsl.worlds.protocol import Disturbances


@pytest.mark.parametrize(
    "wrong", [{"slips": 1.5}, {"pushes": -0.1}, {"noise": float("nan")}, {"noise": -1.0}]
)
def test_disturbances_are_probabilities_and_a_finite_noise(wrong: dict[str, float]) -> None:
    with pytest.raises(NtpError, match=next(iter(wrong))):
        Disturbances(**wrong)


def test_what_is_no_world_is_told_what_it_lacks() -> None:
    class Half:
        skills: dict[str, object] = {}

    with pytest.raises(NtpError, match="found Half, which lacks .*reset.*observe"):
        equip(Half(), load("block_stacking"))  # type: ignore[arg-type]
