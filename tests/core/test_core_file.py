"""The file of the one core: small, finite, whole or refused, and of nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch
from one_core_samples import library, the_core
from safetensors.torch import load_file, save_file
from torch import nn

from ntp_dsl.cli.app import run
from ntp_dsl.common.resources import checkpoints_folder
from ntp_dsl.core.dispatch.network import DispatchNetwork
from ntp_dsl.core.models import BaselineModel, OneCoreModel, open_model
from ntp_dsl.core.one_core import FORMAT, VERSION, OneCore, load_one_core, save_one_core, shipped_core
from ntp_dsl.core.perception.grounding import Grounding
from ntp_dsl.language.diagnostics.diagnostics import NtpError

MEGABYTE = 10**6
BASELINE = checkpoints_folder() / "baseline" / "block_stacking.safetensors"
HEADER = {"format": FORMAT, "version": VERSION, "recipe": "{}"}


def refused(path: Path) -> str:
    with pytest.raises(NtpError) as error:
        load_one_core(path)
    with pytest.raises(NtpError):
        open_model(path, library("seating"), "seat")
    message = str(error.value)
    assert message.startswith(f"{path}: ") and "\n" not in message
    return message


def test_the_shipped_core_is_small_and_says_how_it_was_made() -> None:
    assert shipped_core().stat().st_size <= MEGABYTE
    recipe = the_core().recipe
    assert recipe["made_by"] == "ntp pretrain" and {"torch", "ntp_dsl"} <= set(recipe["versions"])
    assert all(
        sum(each.numel() for each in network.parameters()) < 100_000 for network in networks(the_core())
    )


@pytest.mark.minutes
def test_the_shipped_core_is_what_the_code_makes(tmp_path: Path) -> None:
    """Not only the pretraining's own code counts: it learns from what random libraries do."""
    recipe = the_core().recipe
    if recipe["versions"]["torch"] != torch.__version__:
        pytest.skip(f"the core was made by torch {recipe['versions']['torch']}, here is {torch.__version__}")
    assert run(["pretrain", "--seed", str(recipe["pretraining"]["seed"]), "--out", str(tmp_path)]) == 0
    made, shipped = load_file(tmp_path / "core.safetensors"), load_file(shipped_core())
    different = [name for name, each in shipped.items() if not torch.equal(made[name], each)]
    assert made.keys() == shipped.keys() and not different


def test_a_core_comes_back_as_it_was_saved(tmp_path: Path) -> None:
    path = tmp_path / "core.safetensors"
    save_one_core(the_core(), path)
    again = load_one_core(path)
    assert again.recipe == the_core().recipe
    for one, other in zip(networks(the_core()), networks(again), strict=True):
        assert all(torch.equal(each, other.state_dict()[name]) for name, each in one.state_dict().items())
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def networks(core: OneCore) -> tuple[nn.Module, nn.Module]:
    return core.grounding, core.dispatch


@pytest.mark.parametrize("place", [0, 1])
@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_weights_that_are_no_numbers_are_refused(value: float, place: int, tmp_path: Path) -> None:
    core = OneCore(Grounding(), DispatchNetwork(), {})
    with torch.no_grad():
        next(networks(core)[place].parameters())[0, 0] = value
    path = tmp_path / "core.safetensors"
    save_one_core(core, path)
    assert "expected finite weights" in refused(path)


@pytest.mark.parametrize(
    "header, sentence",
    [
        ({}, "found other safetensors"),
        ({**HEADER, "format": "somebody's"}, "found other safetensors"),
        ({**HEADER, "version": "2"}, "found other safetensors"),
        ({**HEADER, "recipe": "{"}, "the core's description is damaged"),
        ({**HEADER, "recipe": "[]"}, "the core's description is damaged"),
        (HEADER, "do not fit this version"),
    ],
)
def test_other_safetensors_are_refused(header: dict[str, str], sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "other.safetensors"
    save_file({"weight": torch.zeros(3)}, path, header or None)
    with pytest.raises(NtpError, match=sentence) as error:
        load_one_core(path)
    assert str(error.value).startswith(f"{path}: ") and "\n" not in str(error.value)


@pytest.mark.parametrize("change", ["one less", "one more", "a shape", "a type"])
def test_weights_that_do_not_fit_are_refused(change: str, tmp_path: Path) -> None:
    tensors = load_file(shipped_core())
    name = next(each for each in tensors if tensors[each].dim() == 2)
    match change:
        case "one less":
            del tensors[name]
        case "one more":
            tensors["grounding.more"] = torch.zeros(1)
        case "a shape":
            tensors[name] = tensors[name][:, :-1].contiguous()
        case "a type":
            tensors[name] = tensors[name].double()
    path = tmp_path / "core.safetensors"
    save_file(tensors, path, HEADER)
    assert "`ntp pretrain` makes it anew" in refused(path)


@pytest.mark.parametrize("content", [b"", b"no weights", b"\x00" * 100, b"\xff" * 16])
def test_what_is_no_safetensors_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "core.safetensors"
    path.write_bytes(content)
    assert "expected a checkpoint" in refused(path)
    path.write_bytes(shipped_core().read_bytes()[:-100])
    assert "truncated" in refused(path)


def test_a_file_that_is_not_there_says_what_makes_it(tmp_path: Path) -> None:
    assert "`ntp pretrain` makes them" in refused(tmp_path / "none.safetensors")
    assert "no such checkpoint" in refused(tmp_path)


def test_which_model_a_file_holds_is_known_by_itself() -> None:
    registry = library("block_stacking")
    assert isinstance(open_model(shipped_core(), registry, "stack"), OneCoreModel)
    assert isinstance(open_model(BASELINE, registry, "stack"), BaselineModel)
    with pytest.raises(NtpError, match="found other safetensors"):
        load_one_core(BASELINE)
