"""The shipped checkpoint, loaded once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from ntp_dsl.common.resources import checkpoints_folder

if TYPE_CHECKING:
    from ntp_dsl.core.per_library.checkpoint import Checkpoint


@pytest.fixture(scope="session")
def shipped() -> Checkpoint:
    from ntp_dsl.core.per_library.checkpoint import (
        load_core,  # not before: where torch is missing, this folder is skipped
    )
    from ntp_dsl.core.per_library.training import use_threads

    use_threads(1)
    return load_core(checkpoints_folder() / "baseline" / "block_stacking.safetensors")
