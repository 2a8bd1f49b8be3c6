"""Checkpoints: whole or refused; and the one that ships, with its recipe."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
import torch
from safetensors import safe_open
from safetensors.torch import save_file

from ntp_dsl.common.decoding import decode
from ntp_dsl.common.resources import checkpoints_folder, examples_folder, library_folder
from ntp_dsl.core.per_library.checkpoint import Checkpoint, check_fits, load_core, save_core, strangers
from ntp_dsl.core.per_library.memory import Memory
from ntp_dsl.datasets.dataset import EpisodeRecorder, RecordingPlan
from ntp_dsl.language.checker import check
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.parsing.parser import parse
from ntp_dsl.language.registry import Registry
from ntp_dsl.tasks.instances import configuration, end_configuration
from ntp_dsl.tasks.task_files import read_tasks

SHIPPED = checkpoints_folder() / "baseline" / "block_stacking.safetensors"
OTHER = """
library other
type Thing
predicate done(t: Thing)
api do(t: Thing)
    achieves done(t)
program all_of_it(t: Thing):
    achieves done(t)
    do(t)
"""


def test_a_checkpoint_comes_back_as_it_was_saved(shipped: Checkpoint, tmp_path: Path) -> None:
    path = tmp_path / "copy.safetensors"
    save_core(shipped.core, shipped.recipe, path)
    copy = load_core(path)
    assert copy.recipe == shipped.recipe and copy.core.memory == shipped.core.memory
    assert copy.core.config == shipped.core.config
    for name, tensor in shipped.core.state_dict().items():
        assert torch.equal(tensor, copy.core.state_dict()[name])
    assert [entry.name for entry in tmp_path.iterdir()] == ["copy.safetensors"]


def test_weights_of_another_core_are_refused_with_what_to_do(shipped: Checkpoint, tmp_path: Path) -> None:
    path = tmp_path / "old.safetensors"
    save_core(shipped.core, shipped.recipe, path)
    with safe_open(path, "pt") as opened:
        facts, names = opened.metadata(), list(opened.keys())
        tensors = {name: opened.get_tensor(name) for name in names[1:]}
    save_file(tensors, path, facts)
    with pytest.raises(NtpError, match="train anew: ntp train") as refused:
        load_core(path)
    assert "\n" not in str(refused.value)


def rewritten(path: Path, change: Callable[[dict[str, str], dict[str, torch.Tensor]], None]) -> Path:
    """Copy the shipped checkpoint with its header or its weights changed."""
    with safe_open(SHIPPED, "pt") as opened:
        header, names = opened.metadata(), list(opened.keys())
        tensors = {name: opened.get_tensor(name) for name in names}
    change(header, tensors)
    save_file(tensors, path, header)
    return path


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_weights_that_are_no_numbers_are_refused(value: float, tmp_path: Path) -> None:
    def change(header: dict[str, str], tensors: dict[str, torch.Tensor]) -> None:
        tensors["end.bias"][0] = value

    with pytest.raises(NtpError, match="expected finite weights"):
        load_core(rewritten(tmp_path / "spoilt.safetensors", change))


HUGE = 10**9
MALFORMED: list[tuple[str, Any]] = [
    *[("config", {name: HUGE}) for name in ("hops", "rounds", "width", "row_width", "kernel")],
    *[("config", {name: 64}) for name in ("hops", "rounds", "type_width")],
    ("config", {"kernel": 4}),
    ("config", {"width": "64"}),
    ("config", {"width": None}),
    ("config", {"width": -1}),
    ("config", {"width": 10**400}),
    ("config", []),
    ("config", "[" * 100_000),
    ("memory", "[" * 100_000),
    ("recipe", '{"a":' * 100_000),
    ("recipe", []),
    ("memory", {"types": [[1]]}),
    ("memory", {"types": 3}),
    ("memory", {"parents": [["Block", "Block"]]}),
    ("memory", {"rows": []}),
    ("memory", {"rows": [{"callees": []}]}),
    ("memory", {"apis": []}),
    ("memory", {"types": []}),
    ("memory", {"library": 10**400}),
]


@pytest.mark.parametrize("part, change", MALFORMED, ids=range(len(MALFORMED)))
def test_a_malformed_description_is_refused_at_once(part: str, change: Any, tmp_path: Path) -> None:
    def spoil(header: dict[str, str], tensors: dict[str, torch.Tensor]) -> None:
        changed = {**json.loads(header[part]), **change} if isinstance(change, dict) else change
        header[part] = change if isinstance(change, str) else json.dumps(changed)

    path = rewritten(tmp_path / "spoilt.safetensors", spoil)
    started = time.perf_counter()
    with pytest.raises(NtpError, match="description is damaged|do not fit the core") as refused:
        load_core(path)
    assert time.perf_counter() - started < 5 and str(refused.value).isprintable()


@pytest.mark.parametrize("kept", [0, 7, 100, 5000, -1])
def test_a_checkpoint_that_was_cut_off_is_refused_in_one_sentence(kept: int, tmp_path: Path) -> None:
    path = tmp_path / "cut.safetensors"
    path.write_bytes(SHIPPED.read_bytes()[:kept])
    with pytest.raises(NtpError, match="expected a checkpoint"):
        load_core(path)


def test_safetensors_of_something_else_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "foreign.safetensors"
    save_file({"weight": torch.zeros(3)}, path)
    with pytest.raises(NtpError, match="found other safetensors"):
        load_core(path)


def test_a_missing_checkpoint_says_what_makes_one(tmp_path: Path) -> None:
    with pytest.raises(NtpError, match="ntp train"):
        load_core(tmp_path / "none.safetensors")


def test_a_checkpoint_of_another_library_is_refused(shipped: Checkpoint) -> None:
    other = check(parse(OTHER))
    with pytest.raises(NtpError, match="of library 'block_stacking'.*not seen all_of_it.*'other'"):
        check_fits(shipped.core.memory, other, "all_of_it", SHIPPED)


def test_a_memory_comes_back_from_json(stacking: Registry) -> None:
    memory = Memory.of(stacking)
    assert decode(json.dumps(asdict(memory)), Memory) == memory


def test_the_shipped_checkpoint_fits_the_shipped_library(stacking: Registry, shipped: Checkpoint) -> None:
    assert strangers(shipped.core.memory, stacking, "stack") == []


def test_a_new_task_needs_no_new_checkpoint_and_a_changed_program_does(shipped: Checkpoint) -> None:
    text = (examples_folder() / "block_stacking" / "block_stacking.ntp").read_text()
    tabletop = parse((library_folder() / "tabletop.ntp").read_text())
    renamed = text.replace("library block_stacking", "library mine")
    mine = check(parse(renamed.replace("task few_placements", "task two_or_three")), tabletop)
    assert strangers(shipped.core.memory, mine, "stack") == []
    body = "for p in goal:\n        pick_and_place(p.item, p.support)"
    assert body in renamed
    changed = check(parse(renamed.replace(body, body + "\n    put_down()")), tabletop)
    assert strangers(shipped.core.memory, changed, "stack") == ["stack"]


def test_the_shipped_checkpoint_is_small() -> None:
    assert SHIPPED.stat().st_size <= 5_000_000


@pytest.mark.authors_data
def test_no_end_configuration_of_the_authors_was_trained_on(shipped: Checkpoint, authors_data: Path) -> None:
    files = authors_data.glob("*.json")
    theirs = frozenset(configuration(entry.goal) for path in files for entry in read_tasks(path))
    assert len(theirs) == 1500
    for data in shipped.recipe["data"]:
        assert data["excluded"] == len(theirs)
        plan = RecordingPlan(
            Path("block_stacking"), data["task"], Path("."), seed=data["seed"], excluded=theirs
        )
        recorder = EpisodeRecorder(plan)
        ours = {end_configuration(recorder.instance(n).goal) for n in range(data["episodes"])}
        assert not ours & theirs
