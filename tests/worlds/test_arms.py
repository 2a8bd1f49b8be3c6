"""The domains are carried out by any arm, which stands so that it works where objects are."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

from kinematics.ik.global_ik import InverseKinematics
from kinematics.robot.models import mujoco_model
from kinematics.robot.robot import SHIPPED, load, with_base_at
from kinematics.simulation.bullet_cell import BulletCell
from kinematics.skills.workspace import workspace_of
from ntp_dsl.common.resources import examples_folder
from ntp_dsl.evaluation.episodes import Evaluator, Plan
from ntp_dsl.language.diagnostics.diagnostics import NtpError
from ntp_dsl.language.loader import load as load_library
from ntp_dsl.worlds.catalogue import make_world


@pytest.mark.parametrize("name", SHIPPED)
def test_an_arm_that_stands_elsewhere_stands_there_for_every_library(name: str) -> None:
    away = np.array([0.07, -0.2, 0.0])
    robot, moved = load(name), with_base_at(load(name), 0.07, -0.2)
    expected = InverseKinematics(robot).forward(robot.home)[:3, 3] + away
    model = mujoco_model(moved)
    data = mujoco.MjData(model)
    data.qpos[:] = moved.home
    mujoco.mj_kinematics(model, data)
    with BulletCell(moved) as cell:
        cell.reset([], 0)
        assert np.allclose(InverseKinematics(moved).forward(moved.home)[:3, 3], expected, atol=1e-9)
        assert np.allclose(data.body(moved.tool_frame).xpos, expected, atol=1e-6)
        assert np.allclose(cell.tool_position(), expected, atol=1e-4)  # it holds itself up by motors
    assert np.allclose(workspace_of(moved).region, np.add(workspace_of(robot).region, away[:2, None]))


def test_another_arm_carries_out_what_an_expert_decides(tmp_path: Path) -> None:
    library = examples_folder() / "block_stacking"
    plan = Plan(library, "block_stacking", None, "bullet", 3, arm="xarm6", traces=tmp_path)
    episode = Evaluator(plan).episode(0)
    assert episode.success, episode.reason
    header = json.loads(next(tmp_path.glob("*.jsonl")).read_text().splitlines()[0])
    assert header["arm"] == "xarm6"


@pytest.mark.parametrize(
    "world, arm, told",
    [
        ("kinematic", "xarm6", "the kinematic world has no arm; --arm goes with --world bullet"),
        ("bullet", "nobodys", "'nobodys' is neither an arm nor a file; the arms are panda, xarm6"),
    ],
)
def test_an_arm_that_cannot_be_is_said(world: str, arm: str, told: str) -> None:
    with pytest.raises(NtpError, match=told):
        make_world(world, load_library("block_stacking"), arm=arm)
