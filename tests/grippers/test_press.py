"""The force of the fingers changes softly, corrects itself, and keeps them in step."""

import pytest

from bt_manip.grippers.two_finger.press import Press

DT = 1e-3


def test_a_measured_shortfall_is_made_up_for():
    press = Press()
    press.begin(0.0)
    press.change(50.0, 0.0)
    for _ in range(100):
        press.advance(DT, 49.0)
    f, _ = press.forces(0.0, 0.0, 0.0, 0.0, 0.0)
    assert -f == pytest.approx(50.0 + 5.0 * 1.0 * 0.1)


@pytest.mark.parametrize(
    ("friction", "mass", "bound", "damping"),
    [(0.0, 0.0, 10.0, 20.0), (4.0, 0.1, 10.0, 20.0), (8.0, 0.5, 16.0, 50.0)],
)
def test_the_correction_is_bounded_and_each_finger_damped(friction, mass, bound, damping):
    press = Press(friction, mass)
    press.begin(1e-3)
    press.change(50.0, 0.0)
    for measured, trim in ((0.0, bound), (200.0, -bound)):
        for _ in range(10_000):
            press.advance(DT, measured)
        step = 0.5 * (1000.0 * 2e-3 + 30.0 * (0.02 + 0.05))
        expected = -50.0 - trim - step - damping * 0.02, -50.0 - trim + step + damping * 0.05
        assert press.forces(1000.0, 30.0, 3e-3, 0.02, -0.05) == pytest.approx(expected)


def test_fingers_keep_the_difference_that_they_had_with_a_share_of_the_force():
    press = Press()
    press.begin(1e-3)
    press.change(50.0, 0.0)
    press.advance(DT, 50.0)
    # The first is too far out: it closes harder, the second gives way, their sum stays.
    for difference, step in ((1e-3, 0.0), (3e-3, 1.0), (1.0, 15.2), (-1.0, -15.2)):
        expected = -50.0 - step, -50.0 + step
        assert press.forces(1000.0, 0.0, difference, 0.0, 0.0) == pytest.approx(expected)
