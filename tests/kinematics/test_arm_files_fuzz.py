"""A mutated TOML or URDF of an arm loads, or is refused in one sentence within seconds; nothing else."""

import random
import re
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from kinematics_arms import waist5

from kinematics.collision.self_contact import always_touching
from kinematics.errors import UnusableRobot, UnusableShape
from kinematics.robot import models
from kinematics.robot.gripper import gripper_of
from kinematics.robot.robot import FOLDER, load
from kinematics.simulation.camera import Camera

CASES, SOAK_CASES = 200, 10_000
LONGEST_WAIT = 5.0  # [s]
WORDS = [
    "${h}", "-175deg", "nan", "inf", "-inf", "1e400", "1" + "0" * 400, "1e300", "1e-300", "-1", "0",
    "1", "3.5", "true", '""', "''", "{}", "[]", "[[1]]", "[" * 500, "{" * 500, "<a>" * 200,
    "</link>", "<link/>", "<joint/>", "<!--", "-->", "&#10;", "&amp;", "&a;", "é", "\0", "\x1b[2J",
    "\n", "'", '"', "=", "world", "base", "body", "waist", "finger_a", "tool_of_kinematics",
    "fixed", "continuous", "prismatic", "floating", "planar", "../..", "package://", "/dev/zero",
    "/", "a" * 5_000, "<material/>", "<!DOCTYPE a>", "1979-05-27", "0x10", "1_000",
    "allowed_collisions = [['base', 'body']]\n", "without_collision = ['base']\n",
]  # fmt: skip
TOKEN = r"[\w.+-]+|\"[^\"]*\"|<[^>]*>|\s+|."

Mutation = Callable[[random.Random, list[str]], None]


def replace(chance: random.Random, tokens: list[str]) -> None:
    tokens[chance.randrange(len(tokens))] = chance.choice(WORDS)


def insert(chance: random.Random, tokens: list[str]) -> None:
    tokens.insert(chance.randrange(len(tokens)), chance.choice(WORDS))


def remove(chance: random.Random, tokens: list[str]) -> None:
    first = chance.randrange(len(tokens))
    del tokens[first : first + chance.choice((1, 1, 2, 5, 30))]


def swap(chance: random.Random, tokens: list[str]) -> None:
    a, b = (chance.randrange(len(tokens)) for _ in range(2))
    tokens[a], tokens[b] = tokens[b], tokens[a]


def repeat(chance: random.Random, tokens: list[str]) -> None:
    first = chance.randrange(len(tokens))
    part = tokens[first : first + chance.choice((1, 5, 30))]
    tokens[first:first] = part * chance.choice((1, 2, 100))


def change_within(chance: random.Random, tokens: list[str]) -> None:
    """Exchange one attribute's or word's content, so that the rest stays well-formed."""
    chosen = [k for k, token in enumerate(tokens) if re.search(r"[\w.]", token)]
    at = chance.choice(chosen)
    words = re.findall(r"\w[\w.-]*|\W+", tokens[at])
    words[chance.randrange(len(words))] = chance.choice(WORDS)
    tokens[at] = "".join(words)


MUTATIONS: list[Mutation] = [replace, insert, remove, swap, repeat, *[change_within] * 5]


def mutated(chance: random.Random, text: str) -> bytes:
    tokens = re.findall(TOKEN, text, re.DOTALL)
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        if len(tokens) > 1:
            chance.choice(MUTATIONS)(chance, tokens)
    content = "".join(tokens).encode()
    if chance.random() < 0.05:
        at = chance.randrange(len(content) + 1)
        content = content[:at] + chance.randbytes(3) + content[at:]
    return content


def use(path: Path) -> None:
    """Load an arm, and build all that a run builds of it."""
    load.cache_clear()
    robot = load(str(path))
    gripper_of(robot)
    always_touching(robot)
    models.pinocchio_model(robot)
    models.mujoco_model(robot)
    Camera(robot).close()


@pytest.mark.parametrize("spoilt", ["panda.toml", "waist5.toml", "waist5.urdf"])
def test_a_mutated_arm_loads_or_is_refused_in_one_sentence(spoilt: str, tmp_path: Path, soak: bool) -> None:
    toml = waist5(tmp_path)
    sources = {
        "panda.toml": (FOLDER / "panda.toml", tmp_path / "mine.toml", tmp_path / "mine.toml"),
        "waist5.toml": (toml, toml, toml),
        "waist5.urdf": (toml.with_suffix(".urdf"), toml.with_suffix(".urdf"), toml),
    }
    source, target, arm = sources[spoilt]
    text = source.read_text()
    before = sorted({*tmp_path.iterdir(), target})
    loaded = 0
    for seed in range((SOAK_CASES if soak else CASES) // len(sources)):
        target.write_bytes(mutated(random.Random(f"{spoilt} {seed}"), text))
        started = time.perf_counter()
        try:
            use(arm)
            loaded += 1
        except (UnusableRobot, UnusableShape) as refused:
            message = str(refused)
            assert message.isprintable() and 20 < len(message) < 1_600, (seed, message)
            assert "no check foresaw" not in message, (seed, message)
        except Exception as unexpected:
            raise AssertionError(f"seed {seed} of {spoilt}") from unexpected
        assert time.perf_counter() - started < LONGEST_WAIT, seed
        assert sorted(tmp_path.iterdir()) == before, seed
    assert loaded
