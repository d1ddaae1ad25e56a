"""The reach of an arm whose tool points down."""

from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Payload, Robot, compile_alone, panda
from bt_manip.spatial import pose
from bt_manip_setup import reach as module
from bt_manip_setup.finger_travel import measured
from bt_manip_setup.inspection import ReachMap, make_robot, reach_map
from bt_manip_setup.reach import DownwardReach, RadialReach


def test_a_position_is_covered_where_all_four_measured_ones_around_it_are_reached():
    rng = np.random.default_rng(0)
    radii, heights = np.linspace(0.2, 0.9, 8), np.linspace(-0.3, 0.8, 7)
    lowest = np.where(rng.uniform(size=(7, 8)) < 0.8, 0.5, -np.inf)
    floor = -0.25
    below = heights[1] - floor  # at the second height, the gripper touches the floor
    reach = RadialReach(np.zeros(2), 0.0, radii, heights, lowest, below_tool=below)
    above = (lowest > floor) & (np.arange(7) > 0)[:, np.newaxis]
    assert reach.reached(floor).tolist() == above.tolist()
    radius, height = rng.uniform(0.1, 1.0, 400), rng.uniform(-0.4, 0.9, 400)
    height[:50] = heights[1] - rng.choice((9e-4, 1.1e-3), 50)  # tolerance: 1 mm
    expected = [
        bool(height[k] - below > floor - 1e-3)
        and any(
            radii[j] <= radius[k] <= radii[j + 1]
            and heights[i] <= height[k] <= heights[i + 1]
            and bool((lowest[i : i + 2, j : j + 2] > floor).all())
            for i in range(6)
            for j in range(7)
        )
        for k in range(400)
    ]
    assert 20 < sum(expected) < 380
    assert reach.covers(radius, height, floor).tolist() == expected


def test_the_payload_takes_a_joint_to_its_effort_limit_where_the_arm_is_weakest(monkeypatch):
    robot = Robot(panda(), gripper=TwoFingerGripper)
    compile_alone(robot)
    model, reached, zero = robot.make_model(), [], np.zeros(7)
    force = model.static_force
    monkeypatch.setattr(model, "static_force", lambda q, up: reached.append(q) or force(q, up))
    found = reach_map(robot, model)
    loaded = model.with_payload(Payload(found.payload))
    use = [np.abs(loaded.rnea(q, zero, zero) / model.limits.effort).max() for q in reached]
    assert len(use) == found.reached.sum() > 4 and max(use) == pytest.approx(1.0, abs=1e-3)
    force = 2.0 * robot.gripper.default_force()  # of two fingers, with a friction of 1
    assert 0.94 < 9.81 * found.gripped / force <= 1.0


def test_the_fingertips_must_not_reach_the_table_before_the_tool_grips(parts):
    """The Panda's reach 9 mm below the tool, and here the tool is 40 mm higher."""
    moved = measured(replace(panda(), T_ft=pose((0.0, 0.0, -0.04))))
    robot = make_robot(moved, parts)
    found = reach_map(robot, robot.make_model())
    assert found.below_tool == pytest.approx(0.049, abs=1e-3) and not found.reached.any()


def test_a_reach_map_is_drawn_with_the_payload():
    reached = np.array([[True, False, True], [True, True, True]])
    drawn = ["  #.#", "  ###"]
    assert ReachMap(reached, 2.345, np.inf, 0.0).lines() == [
        "reach: 83 % of the table from above (#), in squares of 0.1 m; x to the right",
        *drawn,
        "payload: 2.3 kg wherever it reaches the table",
    ]
    assert ReachMap(reached, 2.0, 0.456, 0.0).lines()[-1].endswith("; the grip holds 0.46 kg")


def arm_of(**parts) -> DownwardReach:
    """Return a measurement of an arm that is made of its answers."""
    arm = object.__new__(DownwardReach)
    vars(arm).update(parts)
    return arm


@pytest.mark.parametrize("eighth", range(-3, 5))
def test_the_reach_is_measured_about_the_first_vertical_hinge_in_front_of_the_arm(eighth):
    model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody><body pos="0.1 -0.2 0">
      <joint type="slide" axis="0 0 1"/><joint axis="1 0 0"/><joint axis="0 0 -1" pos="0.05 0.1 0"/>
      <geom size="0.1"/></body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    axis, front = np.array([0.15, -0.1]), eighth * np.pi / 4
    middle, half = np.array([0.4, 0.0]), np.array([1.0, 0.5])

    def solve(position, q0, floor=0.0):
        """Return hinge and radius where a tool of 0.35 to 1.6 m points down."""
        radial = position[:2] - axis
        turn = (np.arctan2(*radial[::-1]) - front + np.pi) % (2.0 * np.pi) - np.pi
        found = np.hypot(*radial), 0.4 + turn, position[2]
        return np.array([found[1], found[0], found[2]]) if 0.35 < found[0] < 1.6 else None

    arm = arm_of(
        _robot=SimpleNamespace(mj_model=model, mj_data=data, dof_adr=np.arange(3)),
        _model=SimpleNamespace(pose=lambda q: pin.SE3(np.eye(3), np.array([*axis + q - 1, 3.0]))),
        _middle=middle, _half=half, solve=solve,
        lowest=SimpleNamespace(of_links=lambda q: q[1] - 2 * q[2], below_tool=lambda q: q[1] / 4),
    )  # fmt: skip
    found = arm.measure()
    assert found.axis == pytest.approx(axis)
    assert np.cos(found.front - front) == pytest.approx(1.0)
    size = found.radii[-1]  # of the farthest of many random configurations
    assert 2.1 < size <= np.hypot(1.6, 1.5)
    assert found.heights[-1] == pytest.approx(0.8 * size) and found.heights[0] < -0.25 * size
    r, z = np.meshgrid(found.radii, found.heights)
    expected = np.where((r > 0.35) & (r < 1.6), r - 2.0 * z, -np.inf)
    assert np.isfinite(expected).any() and found.lowest == pytest.approx(expected)
    assert found.below_tool == pytest.approx(r[np.isfinite(expected)].max() / 4)
    towards, q = arm.front(axis, 1.2)  # half way out
    assert np.cos(towards - front) == pytest.approx(1.0) and q == pytest.approx([0.4, 0.6, 0.24])


def test_a_configuration_for_a_position_is_the_first_above_0_or_the_highest_free_one(monkeypatch):
    monkeypatch.setattr(module, "downward_problem", lambda ik, position: None)
    height, collides = {1: -0.2, 2: -0.1, 3: 0.3, 4: 0.5, 5: -0.05, 6: 0.6}, {4}
    solved, asked = [], []
    arm = arm_of(
        _ik=SimpleNamespace(
            solve=lambda problem, q0, restarts: SimpleNamespace(q=(q0[0],), solved=bool(solved)),
            solutions=lambda problem, q0, restarts: [SimpleNamespace(q=(q,)) for q in asked],
        ),
        lowest=SimpleNamespace(of_links=lambda q: height[q[0]]),
        _is_free=lambda q: q[0] not in collides,
    )  # fmt: skip

    def solution(first, others, *floor):
        asked[:] = others
        found = arm.solve(np.zeros(3), [first], *floor)
        return None if found is None else found[0]

    assert solution(3, (1, 4, 2, 5), -1.0) == 5 and solution(3, (5, 3, 6), -1.0) == 3
    assert solution(3, (), -1.0) is None
    assert solution(3, (1, 6)) == 6 and solution(3, (1, 5)) is None  # by default the floor is at 0
    assert solution(3, (1, 2), -0.15) == 2 and solution(3, (1, 2), -0.05) is None
    solved.append(True)
    assert solution(3, (2,), -1.0) == 3
    assert solution(4, (2, 3), 0.0) == 3 and solution(1, (2,), -1.0) == 2


def test_home_is_near_the_middle_of_the_ranges_above_the_floor_clear_and_not_singular(monkeypatch):
    """Offsets from the middle count relative to the ranges, of 4 and 1 rad here."""
    monkeypatch.setattr(module, "downward_problem", lambda ik, position: None)
    near, far, middle = (3.3, -1.0), (3.0, -0.75), (2.0, -1.0)
    wide, edge = (3.5, -0.65), (3.98, -1.0)
    low, links, close = (2.1, -1.0), (2.0, -0.99), (2.0, -1.01)
    order = [edge, wide, far, near, middle, low, links, close]
    heights = {low: 0.1}
    # With 2 x^2 + x^8 - 0.3 log(manipulability), the costs of near, wide, far: 0.877, 0.883, 0.903.
    volumes = {middle: 0.0, far: np.exp(0.35), wide: np.exp(4.6)}

    def collisions(q, within):
        return [SimpleNamespace(first="a", second="b")] if tuple(q) == close and within else []

    arm = arm_of(
        _ik=SimpleNamespace(solutions=lambda *_, **__: [SimpleNamespace(q=q) for q in order]),
        _middle=np.array([2.0, -1.0]), _half=np.array([2.0, 0.5]), _colliding=Counter(),
        _world=SimpleNamespace(collisions=collisions),
        _model=SimpleNamespace(
            pose=lambda q: pin.SE3(np.eye(3), np.array([0.0, 0.0, heights.get(tuple(q), 0.5)])),
            jacobian=lambda q: np.eye(6, 2) * np.sqrt(volumes.get(tuple(q), 1.0)),
        ),
        lowest=SimpleNamespace(
            below_tool=lambda q: 0.15, of_links=lambda q: -0.1 if tuple(q) == links else 0.3
        ),
    )  # fmt: skip
    assert arm.configuration(np.zeros(3), 0.0) == pytest.approx(near)
    assert arm.blocking() == [("a", "b")]
    order.remove(near)
    assert arm.configuration(np.zeros(3), 0.0) == pytest.approx(wide)
    order.remove(wide)
    assert arm.configuration(np.zeros(3), 0.0) == pytest.approx(far)
    assert arm.configuration(np.zeros(3), -0.06) == pytest.approx(low)
