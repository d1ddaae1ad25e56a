"""The reach of an arm whose tool points down."""

import numpy as np
import pytest

from bt_manip.robots import Payload, Robot, compile_alone, panda
from bt_manip_setup.inspection import reach_map
from bt_manip_setup.reach import DownwardReach, RadialReach


def test_a_position_is_covered_where_all_four_measured_ones_around_it_are_reached():
    rng = np.random.default_rng(0)
    radii, heights = np.linspace(0.2, 0.9, 8), np.linspace(-0.3, 0.8, 7)
    lowest = np.where(rng.uniform(size=(7, 8)) < 0.8, 0.5, -np.inf)
    reach = RadialReach(np.zeros(2), 0.0, radii, heights, lowest, below_tool=0.1)
    radius, height = rng.uniform(0.1, 1.0, 400), rng.uniform(-0.4, 0.9, 400)
    floor = -0.25
    expected = [
        bool(height[k] - 0.1 > floor)
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


def test_the_front_of_the_panda_is_ahead_half_way_out_with_the_tool_down():
    robot = Robot(panda())
    compile_alone(robot)
    model = robot.make_model()
    reach = DownwardReach(robot, model)
    azimuth, q = reach.front(np.zeros(2), 0.8)
    assert azimuth == pytest.approx(0.0, abs=0.3)
    T = model.pose(q)
    expected = [0.4 * np.cos(azimuth), 0.4 * np.sin(azimuth), 0.16]
    assert T.translation == pytest.approx(expected, abs=1e-3)
    assert T.rotation[:, 2] == pytest.approx([0.0, 0.0, -1.0], abs=1e-3)


def test_the_payload_takes_a_joint_to_its_effort_limit_where_the_arm_is_weakest(monkeypatch):
    robot = Robot(panda())
    compile_alone(robot)
    model, reached, zero = robot.make_model(), [], np.zeros(7)
    force = model.static_force
    monkeypatch.setattr(model, "static_force", lambda q, up: reached.append(q) or force(q, up))
    found = reach_map(robot, model)
    loaded = model.with_payload(Payload(found.payload))
    use = [np.abs(loaded.rnea(q, zero, zero) / model.limits.effort).max() for q in reached]
    assert len(use) == found.reached.sum() > 4 and max(use) == pytest.approx(1.0, abs=1e-3)
