"""What a controller gives is looked at before the arm gets it, and the arm can be braked after."""

import numpy as np
import pytest

from bt_manip.control import ComputedTorque, Controller, ControllerFault


class Moody(Controller):
    """Holds still until told what else to give."""

    kind = "moody"
    answer = None

    def compute(self, q, v, q_ref, v_ref, a_ref):
        if isinstance(self.answer, Exception):
            raise self.answer
        return np.zeros(2) if self.answer is None else self.answer


class Cutting(Moody):
    cuts_to_limits = True


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (np.array([0.0, np.nan]), "gave nan for the effort of joint 'elbow'"),
        (np.array([-np.inf, 0.0]), "gave -inf for the effort of joint 'shoulder'"),
        (np.zeros(3), r"gave float64 of shape \(3,\) for its efforts, which are an array of 2"),
        (np.zeros((1, 2)), r"gave float64 of shape \(1, 2\)"),
        (np.zeros(()), r"gave float64 of shape \(\)"),
        (0.0, "gave a value of type float for its efforts"),
        ([0.0, 0.0], "gave a value of type list for its efforts"),
        (np.array([0.0, -15.1]), r"gave -15.1 N m for joint 'elbow', whose limit is 15 N m"),
        (ValueError("no\nidea"), "raised ValueError: no idea"),
    ],
    ids=str,
)
def test_what_no_arm_can_be_driven_with_is_a_fault_and_never_gets_there(make_arm, answer, message):
    cell, robot, control = make_arm(Moody)
    cell.step(3)
    control.answer = answer
    with pytest.raises(ControllerFault, match=message) as caught:
        cell.step()
    assert cell.data.ctrl.tolist() == [0.0, 0.0]
    assert caught.value.culprit == __name__
    assert "controller 'moody'" in str(caught.value) and "at 0.003 s" in str(caught.value)


def test_from_the_fault_on_the_arm_is_held_by_a_plain_controller(make_arm):
    cell, robot, control = make_arm(Moody)
    cell.step(50)
    assert abs(robot.v).max() > 0.1  # it falls
    control.answer = np.full(2, np.nan)
    with pytest.raises(ControllerFault):
        cell.step()
    cell.step(3000)
    assert abs(robot.v).max() < 1e-3
    assert abs(robot.q - control.reference.q).max() < 0.05


def test_a_new_episode_gives_the_controller_another_chance(make_arm):
    cell, _, control = make_arm(Moody)
    control.answer = np.full(2, np.nan)
    with pytest.raises(ControllerFault):
        cell.step()
    control.reset()
    with pytest.raises(ControllerFault):
        cell.step()
    control.reset()
    control.answer = None
    cell.step()


def test_efforts_at_the_limits_are_inside_them(make_arm):
    cell, _, control = make_arm(Moody)
    control.answer = np.array([40.0, -15.0])
    cell.step()
    assert cell.data.ctrl.tolist() == [40.0, -15.0]
    assert control.saturated_steps == 0


def test_who_says_so_has_its_efforts_cut_instead(make_arm):
    cell, _, control = make_arm(Cutting)
    control.answer = np.array([50.0, 1.0])
    cell.step()
    assert cell.data.ctrl.tolist() == [40.0, 1.0]
    assert control.saturated.tolist() == [True, False]
    control.answer = np.array([np.nan, 1.0])
    with pytest.raises(ControllerFault, match="gave nan"):
        cell.step()


@pytest.mark.parametrize("kind", [np.float32, int])
def test_other_types_of_numbers_will_do(make_arm, kind):
    cell, _, control = make_arm(Moody)
    control.answer = np.array([3, -2], dtype=kind)
    cell.step()
    assert cell.data.ctrl.tolist() == [3.0, -2.0]


def test_the_watch_leaves_what_a_sound_controller_does_as_it_is(make_arm):
    cell, robot, control = make_arm(ComputedTorque)
    tau = control.compute(robot.q, robot.v, robot.q, np.zeros(2), np.zeros(2)).copy()
    control.reset()
    cell.step()
    np.testing.assert_allclose(cell.data.ctrl, tau, rtol=1e-12)
