"""Pretraining: the same weights for a seed, however often it was interrupted; and files that it refuses."""

from __future__ import annotations

import json
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors import safe_open
from safetensors.torch import load_file, save_file

from ntp_dsl.cli.app import INTERRUPTED, MISUSE, run
from ntp_dsl.cli.commands import pretrain
from ntp_dsl.common.resources import checkpoints_folder
from ntp_dsl.core.one_core import load_one_core, shipped_core
from ntp_dsl.core.pretraining.config import PretrainingConfig
from ntp_dsl.core.pretraining.dispatch_data import Sample
from ntp_dsl.core.pretraining.grounding_data import Parts, joined, of_scene
from ntp_dsl.core.pretraining.nameless_programs import nameless
from ntp_dsl.core.pretraining.nameless_sequences import sequence
from ntp_dsl.core.pretraining.pretraining import Pretraining
from ntp_dsl.language.diagnostics.diagnostics import NtpError

TINY = PretrainingConfig(
    seed=3, scenes=6, iterations=12, programs=30, sequences=4, libraries=0, dispatch_iterations=8
)
SIZES = ["--seed", "3", "--scenes", "6", "--iterations", "12", "--programs", "30", "--libraries", "0"]
SIZES += ["--sequences", "4"]
WORDS = ["pretrain", *SIZES, "--dispatch-iterations", "8"]
PARTIAL, CORE = "pretraining.safetensors", "core.safetensors"

Weights = dict[str, torch.Tensor]
Data = tuple[Parts, list[Sample], list[Sample]]  # scenes, nameless programs, sequences


@pytest.fixture(scope="module")
def data() -> Data:
    return made_up(TINY)


def made_up(config: PretrainingConfig) -> Data:
    parts = joined(each for number in range(config.scenes) for each in of_scene(number, config.seed))
    found = [nameless(np.random.default_rng((config.seed, number))) for number in range(config.programs)]
    in_sequence = [
        each
        for number in range(config.sequences)
        for each in sequence(np.random.default_rng((config.seed, number)))
    ]
    return parts, [each for each in found if each is not None], in_sequence


def go_on(training: Pretraining, data: Data, stop: int | None = None) -> None:
    """Train to the end, or until the iteration, of both networks together, at which somebody interrupts."""

    def report(iteration: int, _: float) -> None:
        if stop is not None and training.grounding.iteration + training.dispatch.iteration == stop:
            raise KeyboardInterrupt

    training.fit_grounding(data[0], report)
    training.fit_dispatch([data[1], []], data[2], report)


def weights_of(training: Pretraining) -> Weights:
    both = {"grounding": training.grounding.network, "dispatch": training.dispatch.network}
    return {f"{name}.{key}": each for name, net in both.items() for key, each in net.state_dict().items()}


def trained(data: Data, stops: tuple[int, ...] = (), folder: Path | None = None) -> Weights:
    """Return the weights, saved and taken up again by another process at some iterations."""
    training = Pretraining(TINY)
    for stop in stops:
        assert folder is not None
        with pytest.raises(KeyboardInterrupt):
            go_on(training, data, stop)
        training.save(folder / PARTIAL)
        torch.manual_seed(stop)  # what is drawn in between must not matter
        torch.rand(3)
        training = Pretraining(TINY)
        training.resume(folder / PARTIAL)
        assert training.grounding.iteration + training.dispatch.iteration == stop
    go_on(training, data)
    return weights_of(training)


def assert_same(some: dict[str, torch.Tensor], others: dict[str, torch.Tensor]) -> None:
    assert some.keys() == others.keys()
    assert all(torch.equal(some[name], others[name]) for name in some)


def test_the_same_seed_makes_up_the_same_scenes_and_programs(data: Data) -> None:
    parts, samples, in_sequence = made_up(TINY)
    for one, other in zip(data[0], parts, strict=True):
        assert np.array_equal(one.inputs, other.inputs)
        assert np.array_equal(one.answers, other.answers, equal_nan=True)
    assert [str(each) for each in samples] == [str(each) for each in data[1]] != []
    assert [str(each) for each in in_sequence] == [str(each) for each in data[2]] != []


def test_the_same_seed_gives_the_same_weights_bit_for_bit(data: Data) -> None:
    assert_same(trained(data), trained(data))


def test_another_seed_gives_other_weights(data: Data) -> None:
    other = Pretraining(replace(TINY, seed=4))
    go_on(other, data)
    own = trained(data)
    assert not all(torch.equal(each, own[name]) for name, each in weights_of(other).items())


@pytest.mark.parametrize("stops", [(5,), (1, 6, 11), (12,), (14,), (3, 12, 13, 19), (20,)])
def test_an_interrupted_training_ends_with_the_same_weights(
    stops: tuple[int, ...], data: Data, tmp_path: Path
) -> None:
    assert_same(trained(data, stops, tmp_path), trained(data))


def test_it_learns(data: Data) -> None:
    training = Pretraining(replace(TINY, iterations=150, dispatch_iterations=60))
    seeing: list[float] = []
    deciding: list[float] = []
    training.fit_grounding(data[0], lambda _, loss: seeing.append(loss))
    training.fit_dispatch([data[1], []], data[2], lambda _, loss: deciding.append(loss))
    for losses, share in ((seeing, 0.5), (deciding, 0.9)):
        assert np.mean(losses[-10:]) < share * np.mean(losses[:10])


# The command


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("whole")
    assert run([*WORDS, "--out", str(out)]) == 0
    return out


def tensors_of(path: Path) -> Weights:
    load_one_core(path)
    return load_file(path)


def test_the_command_leaves_a_core_and_nothing_else(whole: Path, data: Data) -> None:
    assert [path.name for path in whole.iterdir()] == [CORE]
    assert_same(tensors_of(whole / CORE), trained(data))
    recipe = load_one_core(whole / CORE).recipe
    assert recipe["pretraining"] == asdict(TINY)
    assert set(recipe["versions"]) == {"ntp_dsl", "torch", "numpy"}


def test_the_command_makes_the_same_file_twice(whole: Path, tmp_path: Path) -> None:
    assert run([*WORDS, "--out", str(tmp_path)]) == 0
    assert_same(tensors_of(tmp_path / CORE), tensors_of(whole / CORE))


AT = {"making up scenes": 3, "grounding": 7, "making up programs": 11, "dispatching": 5}


@pytest.fixture(params=list(AT))
def interrupted(
    request: pytest.FixtureRequest,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Path:
    """Return the folder of a command that was interrupted in one of its stages."""

    class Bar:
        def __init__(self, at: int) -> None:
            self.count, self.at = 0, at

        def advance(self, steps: int = 1) -> None:
            self.count += steps
            if self.count == self.at:
                raise KeyboardInterrupt

        def describe(self, description: str) -> None: ...

    def progress(what: str, total: int | None) -> AbstractContextManager[Bar]:
        return nullcontext(Bar(AT[what] if what == request.param else -1))

    monkeypatch.setattr(pretrain, "progress", progress)
    assert run([*WORDS, "--out", str(tmp_path)]) == INTERRUPTED
    assert "interrupted" in capsys.readouterr().err
    monkeypatch.undo()
    return tmp_path


def test_after_an_interruption_the_same_command_goes_on(
    interrupted: Path, whole: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert [path.name for path in interrupted.iterdir()] == [PARTIAL]
    assert run([*WORDS, "--out", str(interrupted)]) == 0
    assert "continuing from iteration" in capsys.readouterr().err
    assert [path.name for path in interrupted.iterdir()] == [CORE]
    assert_same(tensors_of(interrupted / CORE), tensors_of(whole / CORE))


@pytest.mark.parametrize(
    "other",
    [["--seed", "4"], ["--scenes", "5"], ["--iterations", "13"], ["--programs", "9"], ["--sequences", "5"]],
)
def test_a_training_with_other_settings_is_not_gone_on_with(
    other: list[str], interrupted: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (interrupted / PARTIAL).read_bytes()
    assert run([*WORDS, *other, "--out", str(interrupted)]) == MISUSE
    said = capsys.readouterr().err.strip()
    assert "was made with other settings" in said and "\n" not in said
    assert (interrupted / PARTIAL).read_bytes() == before


def damaged(kind: str, path: Path) -> None:
    with safe_open(path, "pt") as file:
        header, tensors = dict(file.metadata()), {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    raw = path.read_bytes()
    match kind:
        case "cut off":
            path.write_bytes(raw[: len(raw) // 2])
        case "empty":
            path.write_bytes(b"")
        case "text":
            path.write_text("weights")
        case "without its iteration":
            save_file(tensors, path, {name: each for name, each in header.items() if name != "iterations"})
        case "without its settings":
            save_file(tensors, path, {**header, "config": "{"})
        case "beyond its end":
            save_file(tensors, path, {**header, "iterations": '{"grounding": 99, "dispatch": 99}'})
        case "before its begin":
            save_file(tensors, path, {**header, "iterations": '{"grounding": -1, "dispatch": 0}'})
        case "without weights":
            save_file(
                {n: t for n, t in tensors.items() if not n.startswith("grounding.network.pairs")},
                path,
                header,
            )
        case "of another shape":
            save_file({n: t[:1] if t.dim() else t for n, t in tensors.items()}, path, header)
        case "not finite":
            save_file({n: torch.full_like(t, float("nan")) for n, t in tensors.items()}, path, header)
        case "of a core":
            path.write_bytes(shipped_core().read_bytes())
        case "of a baseline":
            path.write_bytes((checkpoints_folder() / "baseline" / "block_stacking.safetensors").read_bytes())


DAMAGES = [
    "cut off", "empty", "text", "without its iteration", "without its settings",
    "beyond its end",
    "before its begin", "without weights", "of another shape", "not finite", "of a core", "of a baseline",
]  # fmt: skip


@pytest.fixture(scope="module")
def partial(data: Data, tmp_path_factory: pytest.TempPathFactory) -> Path:
    training = Pretraining(TINY)
    with pytest.raises(KeyboardInterrupt):
        go_on(training, data, 15)
    path = tmp_path_factory.mktemp("partial") / PARTIAL
    training.save(path)
    return path


@pytest.mark.parametrize("kind", DAMAGES)
def test_a_damaged_file_is_one_sentence(kind: str, partial: Path, tmp_path: Path) -> None:
    path = tmp_path / PARTIAL
    path.write_bytes(partial.read_bytes())
    damaged(kind, path)
    with pytest.raises(NtpError) as refused:
        Pretraining(TINY).resume(path)
    assert str(refused.value).startswith(f"{path}: ") and "\n" not in str(refused.value)


@pytest.mark.parametrize("kind", ["without its optimiser", "with half of its optimiser", "with another one"])
def test_a_file_with_a_damaged_optimiser_is_one_sentence(
    kind: str, partial: Path, data: Data, tmp_path: Path
) -> None:
    """What is missing must not be begun anew in silence: other weights would come of it."""
    path = tmp_path / PARTIAL
    with safe_open(partial, "pt") as file:
        header, tensors = dict(file.metadata()), {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    own = [name for name in tensors if ".optimiser." in name]
    match kind:
        case "without its optimiser":
            tensors = {name: each for name, each in tensors.items() if name not in own}
        case "with half of its optimiser":
            tensors = {
                name: each for name, each in tensors.items() if not name.startswith("dispatch.optimiser.1.")
            }
        case _:
            tensors |= {name: torch.zeros(2, 2) for name in own if name.endswith("exp_avg")}
    save_file(tensors, path, header)
    with pytest.raises(NtpError) as refused:
        training = Pretraining(TINY)
        training.resume(path)
        go_on(training, data)
    assert "\n" not in str(refused.value)


def test_json_says_where_the_core_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*WORDS, "--out", str(tmp_path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert Path(document["checkpoint"]).is_file() and document["pretraining"] == asdict(TINY)
