"""A description is tried by the task itself, and a failure names the key that may cause it."""

from dataclasses import replace

import pytest

from bt_manip import spatial
from bt_manip.robots import panda
from bt_manip_setup import try_robot

GRIPPER = panda().gripper


def with_gripper(**changes):
    return replace(panda(), gripper=replace(GRIPPER, **changes))


def keys(trial) -> list[str]:
    return [finding.split("key '")[1].split("'")[0] for finding in trial.findings]


def test_a_robot_that_picks_has_no_findings(parts):
    steps: list[str] = []
    trial = try_robot(panda(), parts, cycles=2, report=steps.append)
    assert trial.findings == []
    assert steps == ["a cube on a post", "pick_place: cycle 1 of 2", "pick_place: cycle 2 of 2"]
    assert trial.facts[0] == "pick_place: 2 of 2 cycles, 0 of them with a retry"
    assert trial.facts[1].startswith("tracking error: 0.")


@pytest.fixture(scope="module")
def weak(parts):
    """Try a robot whose grip is too weak for the cube."""
    return try_robot(with_gripper(max_force=0.2), parts, cycles=20)


def test_a_grip_too_weak_for_the_cube_is_found_in_the_air_and_on_the_table(weak):
    assert set(keys(weak)) == {"gripper.max_force"}
    assert "a cube on a post: Hover" in weak.findings[0]
    assert "robot 'panda'" in weak.findings[0] and "; give more" in weak.findings[0]


def test_failures_that_repeat_are_printed_once_with_their_count(weak):
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
    trial = try_robot(replace(panda(), **changes), parts, cycles=3)
    assert key in keys(trial)


def test_a_tool_frame_far_from_the_fingers_is_named_before_what_fails_with_it(parts):
    trial = try_robot(replace(panda(), T_ft=spatial.pose((0.0, 0.0, -0.1))), parts, cycles=1)
    assert keys(trial)[0] == "tool"
    assert "mm from the middle of the finger pads" in trial.findings[0]
