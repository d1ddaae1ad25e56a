"""What libfranka gets and gives, in its units and frames, without a robot."""

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.robots import DeviceError
from bt_manip_franka import FrankaArm, device


def test_the_payload_is_that_in_the_frame_of_the_flange(monkeypatch):
    T_ft = pin.SE3(pin.utils.rotate("z", -np.pi / 4), np.array([0.0, 0.0, 0.1034]))  # by the manual
    loads, limits, rows = [], [], np.arange(28.0).reshape(4, 7)
    names = "q", "dq", "tau_J", "q_d"
    state = SimpleNamespace(**dict(zip(names, rows, strict=True)), tau_ext_hat_filtered=rows[0])
    state.robot_mode, state.current_errors = SimpleNamespace(name="Idle"), ()
    state.time = SimpleNamespace(to_sec=lambda: 1.25)
    robot = SimpleNamespace(
        read_once=lambda: state,
        set_collision_behavior=lambda *given: limits.extend(given),
        set_load=lambda *given: loads.append(given),
    )
    modes = SimpleNamespace(kIgnore="ignore", kEnforce="enforce")
    library = SimpleNamespace(
        Robot=lambda *_: robot, RealtimeConfig=modes, NetworkException=OSError
    )
    monkeypatch.setattr(device, "libfranka", lambda: library)
    arm = FrankaArm("fr3?realtime=ignore&collision_torque=15&collision_force=12")
    arm.connect()
    assert limits == [[15.0] * 7, [15.0] * 7, [12.0] * 6, [12.0] * 6]
    found = arm.read()
    np.testing.assert_array_equal((found.q, found.v, found.tau, found.q_held), rows)
    assert found.time == 1.25 and arm.period == 1e-3 and not found.problem
    inertia = np.array([[3e-3, 4e-4, -2e-4], [4e-4, 2e-3, 1e-4], [-2e-4, 1e-4, 1e-3]])
    held = pin.Inertia(2.9, np.array([0.02, -0.03, 0.05]), inertia)
    for mass, expected in ((2.9, T_ft.act(held)), (0.0, pin.Inertia.Zero())):
        arm.set_payload(mass, held.lever, held.inertia)
        assert loads[-1][0] == mass and loads[-1][1] == pytest.approx(expected.lever)
        assert loads[-1][2] == pytest.approx(expected.inertia.ravel())
    for wrong in (3.1, -0.1):
        with pytest.raises(DeviceError, match="up to 3 kg"):
            arm.set_payload(wrong, held.lever, held.inertia)
