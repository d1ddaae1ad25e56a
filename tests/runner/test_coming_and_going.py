"""Objects come and go while the arm moves; it does not notice."""

import gc
from collections.abc import Iterator

import mujoco
import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.runner import Station
from tests.support.garbage import memory

AWAY = np.array([0.3, -0.2, 0.2, 0.1, -0.2, 0.2, 0.4])
PRESENT = 5


class Swing:
    """Keep the arm moving between two configurations, and note how well it follows."""

    def __init__(self, station: Station) -> None:
        self.station, self.sign = station, 1.0
        self.home = station.robot.q
        self.errors: list[float] = []

    def step(self, n: int) -> None:
        for _ in range(n):
            if not self.station.arm.moving:
                self.station.arm.move_to_configuration(self.home + self.sign * AWAY)
                self.sign = -self.sign
            self.station.cell.step()
            self.errors.append(float(np.abs(self.station.arm.q - self.station.robot.q).max()))


def state_by_joint(station: Station) -> Iterator[tuple[str, str, bytes]]:
    """Give the bits of all that a step depends on, by the names of joints and motors."""
    model, data = station.cell.model, station.cell.data
    for j in range(model.njnt):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, j)
        free = int(model.jnt_type[j]) == int(mujoco.mjtJoint.mjJNT_FREE)
        q, v = model.jnt_qposadr[j], model.jnt_dofadr[j]
        yield name, "qpos", data.qpos[q : q + (7 if free else 1)].tobytes()
        for field in ("qvel", "qacc_warmstart", "qfrc_applied"):
            yield name, field, getattr(data, field)[v : v + (6 if free else 1)].tobytes()
    for u in range(model.nu):
        yield mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, u), "ctrl", data.ctrl[u]


def state(station: Station) -> dict:
    parts = {(name, field): bits for name, field, bits in state_by_joint(station)}
    commands = (station.arm, station.controller, station.gripper)
    return {**parts, "time": station.cell.time, "commands": [c.get_state() for c in commands]}


def built(parts) -> Station:
    station = build_station(parts)
    with station.cell.editing():
        for i in range(PRESENT):
            place = spatial.pose((0.1 + 0.08 * i, 0.3, 1.04))
            station.cell.add(station.models.create("cube"), place)
    return station


def come_and_go(swing: Swing, alone: Swing, times: int) -> None:
    """Let objects come and go beside one arm, and compare it with one that is left alone."""
    station = swing.station
    for i in range(times):
        swing.step(3)
        before = state(station)
        cube = station.models.create("cube")
        name = station.cell.add(cube, spatial.pose((2.0, 0.01 * (i % 100), 0.025)))
        with_it = state(station)
        assert before.items() <= with_it.items() and len(with_it) > len(before)
        swing.step(3)
        before = state(station)
        station.cell.remove(name)
        without = state(station)
        assert without.items() <= before.items() and len(without) < len(before)
        alone.step(6)
    assert 0.0 < max(swing.errors) == pytest.approx(max(alone.errors), rel=0.02)
    assert station.arm.q == pytest.approx(alone.station.arm.q, abs=0)


@pytest.fixture
def swings(parts) -> tuple[Swing, Swing]:
    return Swing(built(parts)), Swing(built(parts))


def test_what_is_there_keeps_every_bit_while_objects_come_and_go_and_the_arm_moves(swings):
    come_and_go(*swings, 10)


def left_behind() -> tuple[int, int]:
    """Give the memory of this process that is in use [bytes], and how many objects Python keeps."""
    gc.collect()
    return memory(), len(gc.get_objects())


@pytest.mark.soak
def test_a_thousand_objects_come_and_go_and_leave_no_memory_behind(swings):
    # In stations that stay: what dropped ones give back, the allocator may keep.
    come_and_go(*swings, 100)
    memory, objects = left_behind()
    come_and_go(*swings, 1000)
    later = left_behind()
    assert later[0] - memory < 10e6  # [bytes], measured 3e6
    assert later[1] - objects < 100
