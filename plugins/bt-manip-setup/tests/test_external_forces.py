"""Motions of described arms without contact raise no alarm, and a push of 15 N at the tool does.

``ARMS`` names further models, paths as in ``PATH``.
"""

import os
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from bt_manip import build_station, load_plugins
from bt_manip.exceptions import MotionError
from bt_manip.models import bundled_path
from bt_manip.robots import RobotDescription
from bt_manip.scenes import table_and_basket
from bt_manip_setup import describe_robot

from .assembled_arms import SIX_JOINTS
from .test_picking import MENAGERIE, MORE

OTHERS = [path for path in os.environ.get("ARMS", "").split(os.pathsep) if path]
MOTIONS, PUSHES = 20, 12
PUSH = 15.0  # [N]
FOUND = 0.8  # least share of pushes found: friction hides those near the axes of stiff joints


class Bench:
    """An arm in free space."""

    def __init__(self, description: RobotDescription, parts) -> None:
        scene = replace(table_and_basket(), objects=())
        self.station = build_station(parts, robot=description, scene=scene)
        self.cell, self.robot, self.arm = self.station.cell, self.station.robot, self.station.arm
        self.rest = self.station.get_state()

    def start(self, rng: np.random.Generator) -> None:
        """Begin a motion to a random configuration at full speed."""
        lower, upper = self.arm.model.limits.sampling_bounds()
        for _ in range(100):
            try:
                self.arm.move_to_configuration(rng.uniform(lower, upper))
                return
            except MotionError:  # in collision with itself
                continue
        raise AssertionError("no free configuration")

    def is_found(self, rng: np.random.Generator) -> bool:
        """Push the tool in a random direction during a motion for 0.1 s."""
        self.station.set_state(self.rest)
        self.start(rng)
        self.cell.step(int(rng.integers(50, 200)))
        model, data, site = self.cell.model, self.cell.data, self.robot.tool_site_id
        direction = rng.normal(size=3)
        force = PUSH * direction / np.linalg.norm(direction)
        for _ in range(100):
            torques, body = np.zeros(model.nv), int(model.site_bodyid[site])
            mujoco.mj_applyFT(model, data, force, np.zeros(3), data.site_xpos[site], body, torques)
            data.qfrc_applied[:] = torques
            self.cell.step()
            if self.arm.fault:
                break
        data.qfrc_applied[:] = 0.0
        return bool(self.arm.fault)


def check_alarms(description: RobotDescription, parts) -> None:
    bench, rng = Bench(description, parts), np.random.default_rng(0)
    for motion in range(MOTIONS):
        bench.start(rng)
        while bench.arm.moving:
            bench.cell.step()
        assert not bench.arm.fault, f"motion {motion}: {bench.arm.fault}"
    found = sum(bench.is_found(rng) for _ in range(PUSHES))
    assert found >= FOUND * PUSHES, f"{found} of {PUSHES} pushes were found"


@pytest.mark.soak
@pytest.mark.parametrize("model", ["bundled panda", "six joints", *MENAGERIE, *MORE, *OTHERS])
def test_only_contacts_raise_an_alarm(menagerie, more_models, parts, model):
    folder, gripper = menagerie, (MENAGERIE | MORE).get(model)
    if model in MORE:
        folder = more_models
    known = {"bundled panda": bundled_path("panda/panda.xml"), "six joints": SIX_JOINTS}
    if model == "six joints":
        parts, gripper = load_plugins().parts, "suction"
    elif gripper is not None:
        gripper = str(folder / gripper)
    path = known.get(model, folder / model)
    check_alarms(describe_robot(str(path), parts, name="arm", gripper=gripper).description, parts)
