"""A description is tried by the task itself, and a failure names the key that may cause it."""

from dataclasses import replace

import pytest

from bt_manip import spatial
from bt_manip.robots import panda
from bt_manip_setup import try_robot

GRIPPER = panda().gripper


def keys(trial) -> list[str]:
    return [finding.split("key '")[1].split("'")[0] for finding in trial.findings]


def test_a_robot_that_picks_has_no_findings(parts):
    steps: list[str] = []
    trial = try_robot(panda(), parts, cycles=1, report=steps.append)
    assert trial.findings == []
    assert steps == ["a cube on a post", "pick_place: cycle 1 of 1"]
    assert trial.facts[0] == "pick_place: 1 of 1 cycles, 0 of them with a retry"
    assert trial.facts[1].startswith("tracking error: 0.")


def test_a_grip_too_weak_for_the_cube_is_found_in_the_air_and_once_on_the_table(parts):
    weak = try_robot(replace(panda(), gripper=replace(GRIPPER, max_force=0.2)), parts, cycles=20)
    assert set(keys(weak)) == {"gripper.max_force"}
    assert "a cube on a post: Hover" in weak.findings[0]
    assert "robot 'panda'" in weak.findings[0] and "; give more" in weak.findings[0]
    (table,) = (finding for finding in weak.findings if "pick_place" in finding)
    assert "pick_place, 3 of 3 cycles: Hover: " in table  # and no further cycles are run


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"effort": (87.0, 87.0, 87.0, 87.0, 12.0, 1.9, 12.0)}, "effort"),
        ({"T_rb": spatial.pose((-2.0, 0.0, 0.0))}, "base"),
    ],
    ids=["weak", "far away"],
)
def test_the_cause_is_named(parts, changes, key):
    trial = try_robot(replace(panda(), **changes), parts, cycles=1)
    assert key in keys(trial)


def test_a_tool_frame_far_from_the_fingers_is_named_before_what_fails_with_it(parts):
    trial = try_robot(replace(panda(), T_ft=spatial.pose((0.0, 0.0, -0.1))), parts, cycles=1)
    assert keys(trial)[0] == "tool"
    assert "mm from the middle of the finger pads" in trial.findings[0]
