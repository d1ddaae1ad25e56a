"""A controller's torques are checked before the motors get them, and the arm can be stopped."""

import numpy as np
import pytest

from bt_manip.control import (
    ComputedTorque,
    ControlError,
    Controller,
    GravityCompensatedPD,
    Reference,
)
from bt_manip.control.exceptions import ControllerFault
from bt_manip.robots import Payload
from bt_manip.spatial import pose


class Scripted(Controller):
    """Returns zero torques until it is told what else to return or raise."""

    kind = "scripted"
    answer = None

    def compute(self, q, v, q_ref, v_ref, a_ref):
        if isinstance(self.answer, Exception):
            raise self.answer
        return np.zeros(2) if self.answer is None else self.answer


class Saturating(Scripted):
    saturates = True


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (np.array([0.0, np.nan]), "returned nan for the torque of joint 'elbow'"),
        (np.array([-np.inf, 0.0]), "returned -inf for the torque of joint 'shoulder'"),
        (np.zeros(3), r"returned float64 of shape \(3,\), expected an array of 2 torques"),
        (np.zeros(()), r"returned float64 of shape \(\)"),
        ([0.0, 0.0], "returned a value of type list"),
        (np.array([0.0, -15.1]), r"returned -15.1 N m for joint 'elbow', whose limit is 15 N m"),
        (ValueError("no\nidea"), "raised ValueError: no idea"),
    ],
    ids=str,
)
def test_invalid_torques_are_a_fault_and_are_never_commanded(make_arm, answer, message):
    cell, robot, control = make_arm(Scripted)
    cell.step(3)
    control.answer = answer
    with pytest.raises(ControllerFault, match=message) as caught:
        cell.step()
    assert cell.data.ctrl.tolist() == [0.0, 0.0]
    assert caught.value.culprit == __name__
    assert "controller 'scripted'" in str(caught.value) and "at 0.003 s" in str(caught.value)


def test_after_a_fault_the_arm_is_held_by_pd_control(make_arm):
    cell, robot, control = make_arm(Scripted)
    cell.step(50)
    assert abs(robot.v).max() > 0.1  # it falls
    control.answer = np.full(2, np.nan)
    with pytest.raises(ControllerFault):
        cell.step()
    cell.step(3000)
    assert abs(robot.v).max() < 1e-3
    assert abs(robot.q - control.reference.q).max() < 0.05


def test_reset_or_a_restored_state_gives_a_faulty_controller_another_chance(make_arm):
    cell, _, control = make_arm(Scripted)
    state = control.get_state()
    control.answer = np.full(2, np.nan)
    for again in (lambda: None, control.reset, lambda: control.set_state(state)):
        again()
        with pytest.raises(ControllerFault):
            cell.step()
    control.reset()
    control.answer = None
    cell.step()


def test_a_reference_needs_only_a_motion_to_be_followed(make_arm):
    class Rest(Reference):
        def __init__(self, q):
            self.q, self.v, self.a = q, 0.0 * q, 0.0 * q

    cell, robot, control = make_arm(GravityCompensatedPD)
    control.reference, control.payload = Rest(robot.q), Payload(0.1)
    cell.step(10)
    assert control.payload.mass == 0.1  # of the controller's own: the reference carries nothing


def test_a_reference_that_lacks_an_attribute_is_refused(make_arm):
    class Rest:
        q = v = a = np.zeros(2)

    _, _, control = make_arm(Scripted)
    with pytest.raises(ControlError, match=r"bt_manip.control.Reference: derive Rest from it"):
        control.reference = Rest()


@pytest.mark.parametrize(
    "answer", [np.array([40.0, -15.0]), np.array([3, -2], np.float32), np.array([3, -2])]
)
def test_torques_up_to_the_limits_are_commanded_unchanged(make_arm, answer):
    cell, _, control = make_arm(Scripted)
    control.answer = answer
    cell.step()
    assert cell.data.ctrl.tolist() == answer.tolist()
    assert control.saturated_steps == 0


def test_the_torques_of_a_saturating_controller_are_clipped(make_arm):
    cell, robot, control = make_arm(Saturating)
    assert Saturating(robot).saturated_steps == 0
    for torques, limited in (([50.0, 1.0], [40.0, 1.0]), ([1.0, -16.0], [1.0, -15.0])):
        control.answer = np.array(torques)
        cell.step()
        assert cell.data.ctrl.tolist() == control.tau.tolist() == limited
        assert control.saturated.tolist() == [torques[0] > 40.0, torques[1] < -15.0]
    assert control.saturated_steps == 2
    control.answer = np.array([np.nan, 1.0])
    with pytest.raises(ControllerFault, match="returned nan"):
        cell.step()


@pytest.mark.parametrize(
    ("kind", "reading"), [(ComputedTorque, "read_v"), (GravityCompensatedPD, "read_q")]
)
def test_joint_whose_measurement_is_not_finite_is_moved_without_feedback(
    make_arm, kind, reading, monkeypatch
):
    cell, robot, control = make_arm(kind)
    cell.step(300)
    q, measure = cell.data.qpos.copy(), getattr(robot, reading)
    monkeypatch.setattr(robot, reading, lambda: np.array([measure()[0], np.nan]))
    cell.step(100)
    assert np.isfinite(control.tau).all() and abs(cell.data.qpos - q).max() < 0.05
    monkeypatch.undo()
    cell.step(500)
    assert abs(robot.q - control.reference.q).max() < 0.05


def test_the_model_of_a_controller_has_the_pose_of_its_moved_robot(make_arm):
    cell, robot, control = make_arm(ComputedTorque)
    turn = (0.9, 0.3, 0.0, 0.1)
    for T_wb in (pose((0.1, 0.0, 0.5), turn), pose((0.1, 0.2, 0.5), turn), pose((0.1, 0.2, 0.5))):
        before = control.model.pose(robot.q)
        moved = T_wb * cell.pose("two_links").inverse()
        cell.move("two_links", T_wb)
        assert control.model.pose(robot.q).isApprox(moved * before, 1e-9)
