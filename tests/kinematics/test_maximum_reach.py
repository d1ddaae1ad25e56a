"""Maximum reach: no configuration exceeds it, and poses beyond it are refused."""

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import minimize

from bt_manip import spatial
from bt_manip.kinematics import PoseTarget
from bt_manip.kinematics.initial_guesses import InitialGuesses
from bt_manip.kinematics.maximum_reach import MaximumReach
from bt_manip.robots import MotionLimits, RobotModel, Tolerance
from tests.measuring.kinematics import random_configurations
from tests.trajectories.pendulum import pendulum


@pytest.fixture
def reach(model) -> MaximumReach:
    return MaximumReach(model, InitialGuesses(model).stored)


def test_targets_beyond_the_reach_are_refused_without_a_search(model, ik):
    far = spatial.pointing_down([2.0, 0.0, 0.3])
    free = ({}, {"cone": 0.2}, {"cone": np.pi}, {"pivot": [0.0, 0.0, 0.05]})
    for target in (far, *(PoseTarget("tool", far, free_axis="z", **given) for given in free)):
        found = ik.solve(target, model.home)
        assert not found.solved and found.iterations == 0
        assert "m out of reach" in found.reason
    assert ik.solve(far, model.home).position_error == pytest.approx(1.7, abs=0.02)


def test_no_target_with_free_rotations_that_the_arm_reaches_is_refused(model, reach, rng):
    refused = 0
    for q in random_configurations(model, rng, 200):
        T, axis, pivot = model.pose(q), rng.normal(size=3), 0.2 * rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        for cone in (0.0, 0.4, 2.0):
            tilt = np.cross(axis, rng.normal(size=3))
            turn = pin.exp3(cone * tilt / np.linalg.norm(tilt)) @ pin.exp3(
                rng.uniform(-3, 3) * axis
            )
            middle = pin.SE3(np.eye(3), pivot)
            turned = T * middle * pin.SE3(turn, np.zeros(3)).inverse() * middle.inverse()
            target = PoseTarget("tool", turned, free_axis=axis, cone=cone, pivot=pivot)
            assert reach.excess(target) == 0.0
            refused += reach.excess(turned) > 0.0
    assert refused > 20


def test_free_rotations_and_tolerances_widen_the_reach(reach):
    # The last joint is 0.107 + 0.1034 m above the tool, the second 0.333 m above the base.
    T, tolerance = spatial.pointing_down([2.0, 0.0, 0.3]), (0.05, 1e-9)
    beside = PoseTarget("tool", T, free_axis="x", tolerance=tolerance)
    tilted = replace(beside, free_axis="z", cone=0.4, pivot=[0.0, 0.0, -0.05])
    for target, height, free in (
        (T, 0.2104, 0.0),
        (beside, 0.0, 0.2104 + 0.05),
        (replace(tilted, cone=2.0), 0.05, 0.1604 + 0.05),
        (tilted, 0.05 + 0.1604 * np.cos(0.4), 0.1604 * np.sin(0.4) + 0.05),
    ):
        expected = np.hypot(2.0, 0.3 + height - 0.333) - reach.distance - free
        assert reach.excess(target) == pytest.approx(expected, abs=1e-6)


CHAIN = """<mujoco><compiler angle="radian"/><worldbody>
<body pos=".3 -.2 .5" quat=".8 .2 -.4 .4"><joint name="0" pos=".02 .03 0" axis=".2 .1 1"/>{0}
<body pos=".1 .2 .3"><joint name="1" axis="0 1 .3" range="{1}"/>{0}
<body pos=".3 0 .1"><joint name="2" axis="1 .2 0" range="{2}"/>{0}
<body pos=".1 -.3 0"><joint name="3" axis=".1 1 .5"/>{0}
<body pos="0 .2 .25"><joint name="4" axis="1 0 1"/>{0}
<site name="tip" pos=".1 .05 .2" quat=".5 .1 -.7 .2"/></body></body></body></body></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize("ranges", [("-.5 .6", "3.5 9"), ("-9 -4", "-2 1"), ("-1 3", "-8 -3.3")])
def test_the_maximum_reach_is_that_of_a_search_with_mujoco(ranges, rng):
    sphere = '<geom size=".02" mass="1"/>'
    chain = mujoco.MjModel.from_xml_string(CHAIN.format(sphere, *ranges))
    data, one = mujoco.MjData(chain), np.ones(5)
    limited = chain.jnt_limited.astype(bool)[:, np.newaxis]
    lower, upper = np.where(limited, chain.jnt_range, [-np.inf, np.inf]).T
    limits = MotionLimits(lower, upper, one, one, one, one)
    arm = RobotModel(
        chain,
        joints=list("01234"),
        tool_frame="tip",
        limits=limits,
        home=[0.0] * 5,
        tolerance=Tolerance(),
        qpos=chain.qpos0,
    )

    def place(q):
        data.qpos[:] = q
        mujoco.mj_kinematics(chain, data)
        axis, first = data.xaxis[0], data.xanchor[0]
        foot = first + axis * (axis @ (data.xanchor[1] - first))
        return data.xanchor[-1] - foot

    bounds = np.where(limited, chain.jnt_range, [-np.pi, np.pi])
    starts = rng.uniform(*bounds.T, (15, 5))
    searches = [
        minimize(lambda q: -np.linalg.norm(place(q)), q, bounds=bounds, tol=1e-12) for q in starts
    ]
    farthest = -min(found.fun for found in searches)
    reach = MaximumReach(arm, rng.uniform(*bounds.T, (60, 5)))
    assert reach.distance == pytest.approx(farthest, abs=1e-6)
    offset = place(starts[0])
    assert reach.distance_at(starts[0]) == pytest.approx(np.linalg.norm(offset))
    for beyond, excess in ((2.0, 2.0), (6e-4, 6e-4), (4e-4, 0.0), (-0.2, 0.0)):  # [m]
        moved = offset * ((reach.distance + beyond) / np.linalg.norm(offset) - 1.0)
        T = pin.SE3(data.site_xmat[0].reshape(3, 3), data.site_xpos[0] + moved)
        assert reach.excess(T) == pytest.approx(excess)
    assert MaximumReach(pendulum(), np.zeros((1, 1))).excess(T) == 0.0
