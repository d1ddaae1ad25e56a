"""What libfranka gets and gives, in its units and frames, without a robot."""

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.robots import DeviceError
from bt_manip_franka import FrankaArm, device

T_FT = pin.SE3(pin.utils.rotate("z", -np.pi / 4), np.array([0.0, 0.0, 0.1034]))
"""Tool frame of the hand in the flange, by Franka's manual."""


@pytest.fixture
def sent(monkeypatch):
    """Replace libfranka by a robot that keeps what it is called with."""
    calls, rows = {}, np.arange(35.0).reshape(5, 7)
    names = "q", "dq", "tau_J", "tau_ext_hat_filtered", "q_d"
    state = SimpleNamespace(
        robot_mode=SimpleNamespace(name="Idle"), current_errors=(),
        time=SimpleNamespace(to_sec=lambda: 1.25), **dict(zip(names, rows, strict=True)),
    )  # fmt: skip

    def connect(*given):
        return SimpleNamespace(
            read_once=lambda: state,
            set_collision_behavior=lambda *limits: calls.update(connect=given, limits=limits),
            set_load=lambda *load: calls.update(load=load),
        )

    modes = SimpleNamespace(kEnforce="enforce", kIgnore="ignore")
    library = SimpleNamespace(Robot=connect, RealtimeConfig=modes, NetworkException=OSError)
    monkeypatch.setattr(device, "libfranka", lambda: library)
    return calls


@pytest.mark.parametrize("realtime", ["ignore", "enforce"])
def test_thresholds_and_a_state_of_seven_joints_are_passed_on(sent, realtime):
    arm = FrankaArm(f"fr3?realtime={realtime}&collision_torque=15&collision_force=12")
    arm.connect()
    assert sent["connect"] == ("fr3", realtime) and arm.period == 1e-3
    assert sent["limits"] == ([15.0] * 7, [15.0] * 7, [12.0] * 6, [12.0] * 6)
    state = arm.read()
    found = state.q, state.v, state.tau, state.tau_external, state.q_held
    np.testing.assert_array_equal(found, np.arange(35.0).reshape(5, 7))
    assert state.time == 1.25 and not state.problem


def test_the_payload_is_that_in_the_frame_of_the_flange(sent):
    arm = FrankaArm("fr3")
    arm.connect()
    inertia = np.array([[3e-3, 4e-4, -2e-4], [4e-4, 2e-3, 1e-4], [-2e-4, 1e-4, 1e-3]])
    held = pin.Inertia(2.9, np.array([0.02, -0.03, 0.05]), inertia)
    arm.set_payload(held.mass, held.lever, held.inertia)
    mass, centre, given = sent["load"]
    expected = T_FT.act(held)
    assert mass == 2.9 and centre == pytest.approx(expected.lever)
    assert given == pytest.approx(expected.inertia.ravel())
    arm.set_payload(0.0, held.lever, held.inertia)
    assert sent["load"] == (0.0, [0.0] * 3, [0.0] * 9)
    for wrong in (3.1, -0.1):
        with pytest.raises(DeviceError, match="up to 3 kg"):
            arm.set_payload(wrong, held.lever, held.inertia)
