"""Residuals and their Jacobians; the oracle is numerical differentiation."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.kinematics.residuals import (
    AxisResidual,
    PoseResidual,
    PositionResidual,
    RotationResidual,
    StackedResidual,
    chord,
)
from tests.measuring.kinematics import differentiate, frame_pose


def residual_of(model, goal, kind):
    frame = model.model.getFrameId("link6")
    T = frame_pose(model, goal, "link6")
    return {
        "position": lambda: PositionResidual(model, frame, T.translation, 1e-6),
        "rotation": lambda: RotationResidual(model, frame, T.rotation, 1e-6),
        "wide position": lambda: PositionResidual(model, frame, T.translation, 0.1),
        "wide rotation": lambda: RotationResidual(model, frame, T.rotation, 0.02),
        "axis": lambda: AxisResidual(model, frame, T.rotation[:, 2], np.eye(3)[2], 1e-6),
        "cone": lambda: AxisResidual(model, frame, T.rotation[:, 2], np.eye(3)[2], 0.02),
        "pivot": lambda: pivoted(model, frame, T),
        "weighted position": lambda: PositionResidual(model, frame, T.translation, np.inf, 3.0),
    }[kind]()


def pivoted(model, frame, T):
    residual = PositionResidual(model, frame, T.act(np.array([0.1, -0.2, 0.3])), 1e-6)
    residual.pivot = np.array([0.1, -0.2, 0.3])
    return residual


@pytest.mark.parametrize(
    "kind",
    [
        "position", "rotation", "wide position", "wide rotation", "weighted position",
        "axis", "cone", "pivot",
    ],
)  # fmt: skip
def test_the_jacobian_of_each_residual_is_its_derivative(model, goal, kind):
    residual = StackedResidual(model, [residual_of(model, goal, kind)])
    q = goal + 0.3 * np.sin(np.arange(7.0))
    expected = differentiate(residual.evaluate, q)
    position, rotation, met = residual.parts[0].errors()
    at, T = (frame_pose(model, x, "link6") for x in (q, goal))
    point = np.array([0.1, -0.2, 0.3]) * (kind == "pivot")
    cosine, of_axis = at.rotation[:, 2] @ T.rotation[:, 2], kind in ("axis", "cone")
    cosine = cosine if of_axis else 0.5 * (np.trace(at.rotation.T @ T.rotation) - 1.0)
    of_position = kind.endswith("position") or kind == "pivot"
    error = np.linalg.norm(at.act(point) - T.act(point)) if of_position else np.arccos(cosine)
    assert (position, rotation) == pytest.approx((error, 0.0) if of_position else (0.0, error))
    length = 2.0 * np.sin(0.5 * error) if of_axis else error * (3.0 if "weighted" in kind else 1.0)
    zone = {"wide position": 0.09, "wide rotation": 0.018, "cone": 1.8 * np.sin(0.01)}.get(kind, 0)
    assert np.linalg.norm(residual.evaluate(q)) == pytest.approx(length - zone)
    assert met == residual.met == residual.reached == (kind == "weighted position")
    assert residual.jacobian() == pytest.approx(expected, abs=1e-7)


def test_the_jacobian_of_a_pose_residual_approaches_its_derivative_at_the_pose(model, goal):
    frame = model.model.getFrameId("link6")
    residual = StackedResidual(
        model, [PoseResidual(model, frame, frame_pose(model, goal, "link6"), (1e-6, 1e-6))]
    )
    for offset in (0.1, 1e-3, 1e-5):
        q = goal + offset * np.sin(np.arange(7.0))
        expected = differentiate(residual.evaluate, q)
        error = np.linalg.norm(residual.evaluate(q))
        assert np.abs(residual.jacobian() - expected).max() <= error + 1e-8


def test_a_target_is_reached_within_its_tolerances_and_met_within_the_accepted_errors(model, goal):
    frame, T = model.model.getFrameId("link6"), frame_pose(model, goal, "link6")
    tolerances, accepted, side = (2e-4, 5e-4), (1e-3, 2e-3), np.array([0.6, -0.48, 0.64])
    for position, rotation, reached, met in (
        (1.9e-4, 4.9e-4, True, True),
        (2.1e-4, 1e-4, False, True),
        (1e-4, 5.1e-4, False, True),
        (9e-4, 1.9e-3, False, True),
        (1.1e-3, 1e-4, False, False),
        (1e-4, 2.1e-3, False, False),
    ):
        aside = T * pin.SE3(pin.exp3(rotation * side), position * side)
        residual = PoseResidual(model, frame, aside, tolerances, accepted)
        stacked = StackedResidual(model, [residual])
        squared = np.sum(stacked.evaluate(goal) ** 2)
        assert residual.errors() == pytest.approx((position, rotation, met), rel=1e-6)
        assert (stacked.reached, stacked.met) == (reached, met)
        assert (squared <= residual.squared_bound) >= reached
        assert (squared <= residual.accepted_bound) >= met
    # The linear part of the logarithm is at most pi / 2 times the distance.
    for bound, most in ((residual.squared_bound, tolerances), (residual.accepted_bound, accepted)):
        assert bound == pytest.approx((0.5 * np.pi * most[0]) ** 2 + most[1] ** 2)
    for given in ((), ((1e-4, 1e-4),)):  # a tolerance is accepted in any case
        assert PoseResidual(model, frame, T, tolerances, *given).accepted == tolerances
    wide = PositionResidual(model, frame, T.translation, 0.1, 1.0, 0.15)  # no residual below 0.09
    assert (wide.squared_bound, wide.accepted_bound) == pytest.approx((0.01**2, 0.06**2))


def test_the_chord_of_an_angle_is_the_distance_of_two_directions_at_it():
    first, axis = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.6, 0.8])
    for angle in (0.0, 1e-3, 1.0, np.pi):
        distance = np.linalg.norm(pin.exp3(angle * axis) @ first - first)
        assert chord(angle) == pytest.approx(distance, abs=1e-12)
    assert chord(4.0) == 2.0 and chord(np.inf) == np.inf  # every direction
