"""A mutated file of any format is read, or refused in one sentence within seconds; nothing else happens."""

from __future__ import annotations

import time
from pathlib import Path
from random import Random

import pytest
from audit import harmless
from formats import Format, formats

from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.registry import Registry

CASES, SOAK_CASES = 100, 10_000
LONGEST_WAIT = 5.0  # [s]
NAMES = [
    "trace", "trace_2", "demonstration", "demonstration_1", "checkpoint", "core", "goal", "tasks",
    "authors_tasks", "manifest", "manifest_1", "poses", "map",
]  # fmt: skip


@pytest.fixture(scope="module")
def every_format(stacking: Registry, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Format]:
    return formats(stacking, tmp_path_factory.mktemp("samples"))


@pytest.mark.parametrize("name", NAMES)
def test_a_mutated_file_is_read_or_refused_in_one_sentence(
    name: str, every_format: dict[str, Format], tmp_path: Path, soak: bool
) -> None:
    assert every_format.keys() == {*NAMES}
    under_test = every_format[name]
    path = tmp_path / under_test.name
    path.write_bytes(under_test.valid)
    under_test.read(path)  # imports all that reading needs
    count_read, slowest = 0, 0.0
    for seed in range(SOAK_CASES if soak else CASES):
        path.write_bytes(under_test.mutation(Random(f"{name} {seed}")))
        before, started = path.read_bytes(), time.perf_counter()
        try:
            with harmless():
                under_test.read(path)
            count_read += 1
        except NtpError as refused:
            message = str(refused)
            assert message.isprintable() and 20 < len(message) < 1_600, (seed, message)
        except Exception as unexpected:
            raise AssertionError(f"seed {seed} of {name}") from unexpected
        slowest = max(slowest, time.perf_counter() - started)
        assert slowest < LONGEST_WAIT, seed
        assert list(tmp_path.iterdir()) == [path] and path.read_bytes() == before, seed
    assert 0 < count_read
    print(f"{name}: {seed + 1} files, {count_read} read, the others refused; slowest {slowest:.2f} s")
