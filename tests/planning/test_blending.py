"""Blends of a bar of 1 m, whose tip moves by the chord of the angle by which it turns."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip.planning import blend
from bt_manip.trajectories import JointTrajectory, TailTrajectory, joint_profiles
from tests.trajectories.pendulum import pendulum

CORNER = 0.8  # [rad]


def turn(start, end, speed=2.0):
    one = np.ones(1)
    rest = start * one, 0.0 * one, 0.0 * one
    return JointTrajectory(joint_profiles(rest, end * one, speed * one, 5.0 * one, 100.0 * one))


def from_corner(trajectory, times):
    """Return the distances of the tip from the corner [m]."""
    return 2.0 * np.sin(0.5 * np.abs(trajectory.sample(times)[0][:, 0] - CORNER))


@pytest.mark.parametrize(
    ("end", "radius", "inside", "delay"),
    [
        (2.0, 0.4, 0.4, 0.0),
        (0.1, 0.4, 0.4, 0.2),
        (1.2, 0.6, 0.9 * 2.0 * np.sin(0.2), 0.0),
        (2.0, 0.25, 0.25, 0.2),
    ],
)
def test_a_blend_leads_to_where_the_next_motion_leaves_the_radius_as_soon_as_it_may_begin(
    end, radius, inside, delay
):
    model = pendulum(effort=1e4, velocity=2.0, acceleration=5.0, jerk=100.0)
    first, second = TailTrajectory(turn(0.0, CORNER), 0.45), turn(CORNER, end)
    blended = blend(first, second, radius, model, None)
    samples = second.duration * np.linspace(0.0, 1.0, 41)
    arrival = samples[np.flatnonzero(from_corner(second, samples) > inside)[0] - 1]
    begin, transition, rest = blended.parts
    start = delay * first.duration
    assert begin is first and rest.start == pytest.approx(arrival)
    whole = start + transition.duration + second.duration - arrival
    assert blended.duration == pytest.approx(whole)
    assert whole < first.duration + second.duration - 0.04
    for t, motion, at in ((0.0, first, 0.0), (start, first, start), (whole, second, 9.0)):
        samples = blended.sample(np.array([t])), motion.sample(np.array([at]))
        for ours, theirs in zip(*samples, strict=True):
            assert ours == pytest.approx(theirs, abs=1e-9)
    last = transition.sample(np.array([transition.duration - 1e-9]))
    for ours, theirs in zip(last, second.sample(np.array([arrival])), strict=True):
        assert ours == pytest.approx(theirs, abs=1e-6)
    assert from_corner(transition, np.linspace(0.0, transition.duration, 99)).max() <= radius


def test_a_blend_in_which_the_tool_would_be_too_fast_is_slowed_a_little():
    model = pendulum(effort=1e4, velocity=2.0, acceleration=5.0, jerk=100.0)
    first, second = TailTrajectory(turn(0.0, CORNER, 0.8), 0.8), turn(CORNER, 2.0, 0.8)
    durations = []
    for tool_speed in (np.inf, 1.0):
        model.limits = replace(model.limits, tool_speed=tool_speed, arm=model)
        blended = blend(first, second, 0.4, model, None)
        v = blended.sample(np.arange(0.0, blended.duration, 1e-3))[1]
        assert (v.max() < 0.995) == (tool_speed == 1.0)
        durations.append(blended.duration)
    assert durations[0] < durations[1] < first.duration + second.duration - 0.04


def test_where_the_radius_or_the_efforts_are_too_small_there_is_no_blend():
    first, second = TailTrajectory(turn(0.0, CORNER), 0.2), turn(CORNER, 2.0)
    limits = {"velocity": 2.0, "acceleration": 5.0, "jerk": 100.0}
    for radius, effort in ((0.01, 1e4), (0.4, 1e-3)):
        assert blend(first, second, radius, pendulum(effort=effort, **limits), None) is None
