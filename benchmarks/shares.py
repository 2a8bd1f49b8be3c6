"""How often a said task is done, as a part of a row: by the expert, and by the core."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ntp_dsl.core.one_core import shipped_core
from ntp_dsl.evaluation.episodes import Plan, run_all
from ntp_dsl.language.diagnostics.diagnostics import NtpError


def shares(
    library: Path, task: str, episodes: int, seed: int, world: str = "kinematic", core: bool = True
) -> Iterator[str]:
    """Yield the share of episodes that each does, with why the first of the others failed."""
    for model in (None, shipped_core()) if core else (None,):
        plan = Plan(library, task, model, world, seed=seed)
        try:
            run = list(run_all(plan, episodes, workers=1))
        except NtpError as error:
            yield f"cannot be run: {str(error).splitlines()[0]}"
            return
        won = sum(bool(each.success) for each in run)
        reason = next((each.reason for each in run if not each.success), "")
        yield f"{won / episodes:g}" + (f" ({reason[:70]})" if reason else "")
