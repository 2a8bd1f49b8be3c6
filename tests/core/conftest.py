"""The shipped checkpoint, loaded once."""

from __future__ import annotations

import pytest

from ntp_dsl.common.resources import checkpoints_folder
from ntp_dsl.core.checkpoint import Checkpoint, load_core
from ntp_dsl.core.training import use_threads


@pytest.fixture(scope="session")
def shipped() -> Checkpoint:
    use_threads(1)
    return load_core(checkpoints_folder() / "block_stacking.safetensors")
