"""States of the controller's clock become readings of a period, without an arm."""

from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip_trossen import WidowXAI, arm

TIMES = (0.0, 0.0005, 0.0019, 0.0021, 0.003, 0.0041, 0.01, 0.0105, 0.0111, 0.0129, 0.0131)


@pytest.fixture
def driver(monkeypatch):
    """Replace the driver by one that has states at `TIMES`, and the time by the sleep."""
    clock, times = SimpleNamespace(now=0.0), iter(TIMES)
    calls = {}

    def output():
        time = calls["time"] = next(times, calls.get("time"))
        names = "positions", "velocities", "efforts", "external_efforts"
        rows = SimpleNamespace(**{n: [time + i] * 6 for i, n in enumerate(names)})
        return SimpleNamespace(
            header=SimpleNamespace(timestamp=round(1e6 * time)), joint=SimpleNamespace(arm=rows)
        )

    made = SimpleNamespace(
        configure=lambda *given: calls.update(configured=given),
        set_all_modes=lambda mode: calls.update(mode=mode),
        get_arm_positions=lambda: [0.25] * 6,
        get_robot_output=output,
        set_arm_positions=lambda *given: calls.update(sent=given),
    )
    library = SimpleNamespace(
        StandardEndEffector=SimpleNamespace(wxai_v0_base="base"), VectorDouble=list,
        TrossenArmDriver=lambda: made, Model=SimpleNamespace(wxai_v0="wxai"),
        Mode=SimpleNamespace(position="position"),
    )  # fmt: skip
    monkeypatch.setattr(arm, "trossen", lambda: library)
    monkeypatch.setattr(arm, "time", SimpleNamespace(
        monotonic=lambda: clock.now, sleep=lambda s: setattr(clock, "now", clock.now + s)
    ))  # fmt: skip
    calls["clock"] = clock
    return calls


def test_readings_are_a_period_apart_also_after_a_late_one_until_none_comes_for_a_second(driver):
    one = WidowXAI("192.168.1.2?end_effector=base")
    one.connect()
    assert driver["configured"] == ("wxai", "base", "192.168.1.2", False, 5.0)
    assert driver["mode"] == "position" and one.period == 2e-3
    states = [one.read() for _ in range(5)]
    assert [state.time for state in states] == pytest.approx([0.0021, 0.0041, 0.01, 0.0111, 0.0131])
    first = states[0]
    for i, values in enumerate((first.q, first.v, first.tau, first.tau_external)):
        np.testing.assert_allclose(values, [0.0021 + i] * 6)
    np.testing.assert_array_equal(first.q_held, [0.25] * 6)
    one.write(np.arange(6.0))
    assert driver["sent"] == ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 0.0, False)
    begin = driver["clock"].now
    lost = one.read()
    assert lost.problem == "connection lost: no new state for 1 s" and lost.recoverable
    assert lost.time == 0.0 and not lost.v.any() and lost.q == pytest.approx([0.0131] * 6)
    assert driver["clock"].now - begin == pytest.approx(1.0 + one.period, abs=5e-4)
