"""What a control step costs beside the physics, and what coming and going costs."""

import os
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
from dm_control import composer, mjcf

from bt_manip import build_station
from bt_manip.arm import Arm
from bt_manip.cell import Basket, Cell, Cube, Region, Table
from bt_manip.cell.physics.state import integration_state
from bt_manip.control import ComputedTorque
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from bt_manip.runner import load_snapshot, save_snapshot
from bt_manip.spatial import pointing_down, pose

BLOCK = 100  # steps
TICK = 10  # steps that a run makes at once
DURATION = 2000  # steps


class Recorder(composer.Entity):
    """Keeps the state and the controls that each step of the physics begins with."""

    def _build(self) -> None:
        self._root = mjcf.RootElement(model="recorder")
        self.states: list[np.ndarray] = []

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """An empty model."""
        return self._root

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Keep them; the recorder is attached last, so controls are written by now."""
        self.states.append(integration_state(physics.model.ptr, physics.data.ptr))


def pick(recorder: Recorder | None = None) -> tuple[Cell, Callable[[int], None]]:
    """Build a pick, and give what has to be done before its steps."""
    robot = Robot(panda(), gripper=TwoFingerGripper)
    control, gripper = ComputedTorque(robot), robot.gripper
    robot.attach(control)
    cell = Cell()
    with cell.editing():
        cell.add(Table())
        cell.add(Basket(), pose((0.68, 0.0, 1.015), (0.5**0.5, 0, 0, 0.5**0.5)))
        cell.add(robot, pose((-0.1, 0.0, 1.015)))
        cell.add(Cube(), pose((0.3, 0.1, 1.04)))
        if recorder is not None:
            cell.add(recorder)
    arm = Arm(robot)
    control.reference = arm

    def command(step: int) -> None:
        if step == 0:
            arm.move_to_pose(pointing_down((0.3, 0.1, 1.055)))
        elif step == 900:
            gripper.close()
        elif step == 1250:
            arm.move_to_pose(pointing_down((0.5, -0.1, 1.3)))

    return cell, command


def control_step() -> tuple[float, float]:
    """Time a whole control step, and the physics alone from the same states; medians [s]."""
    recorder = Recorder()
    recorded, command = pick(recorder)
    for i in range(DURATION):
        command(i)
        recorded.step()
    model, data = recorded.model, mujoco.MjData(recorded.model)
    cell, command = pick()
    whole, alone = [], []
    clock = time.perf_counter
    for first in range(0, DURATION, BLOCK):
        for i in range(first, first + BLOCK, TICK):
            command(i)
            start = clock()
            cell.step(TICK, then=(cell.contact_monitor.summary,))
            whole.append((clock() - start) / TICK)
        for state in recorder.states[first : first + BLOCK]:
            mujoco.mj_setState(model, data, state, mujoco.mjtState.mjSTATE_INTEGRATION)
            start = clock()
            mujoco.mj_step(model, data)
            alone.append(clock() - start)
    return statistics.median(whole), statistics.median(alone)


def coming_and_going(times: int = 15) -> tuple[float, float]:
    """Time inserting and removing an object that was here before, and a step; medians [s]."""
    cell, _ = pick()
    clock, took = time.perf_counter, []
    cube = Cube()
    for i in range(times):
        start = clock()
        cell.remove(cell.add(cube, pose((0.3, -0.2 + 0.01 * i, 1.04))))
        took.append(clock() - start)
    steps = []
    for _ in range(500):
        start = clock()
        mujoco.mj_step(cell.model, cell.data)
        steps.append(clock() - start)
    return statistics.median(took), statistics.median(steps)


def insertion(present: int, times: int = 9) -> tuple[float, float, float]:
    """Time insertion, removal, and PyMJCF's compile of the same scene; medians [s]."""
    cell, _ = pick()
    with cell.editing():
        for i in range(present):
            cell.add(Cube(), pose((2.0, 0.1 * i, 0.025)))
    clock = time.perf_counter
    added, removed, compiled = [], [], []
    for _ in range(times):
        cube = Cube()
        start = clock()
        name = cell.add(cube, pose((0.3, -0.2, 1.04)))
        added.append(clock() - start)
        start = clock()
        mjcf.Physics.from_mjcf_model(cell.arena.mjcf_model)
        compiled.append(clock() - start)
        start = clock()
        cell.remove(name)
        removed.append(clock() - start)
    return statistics.median(added), statistics.median(removed), statistics.median(compiled)


def placing(present: int, times: int = 9) -> float:
    """Time placing among others where the first pose drawn is usually taken; median [s]."""
    cell, _ = pick()
    rng = np.random.default_rng(0)
    region = Region((-0.6, -0.3), (-0.3, 0.3), (1.04, 1.04))
    for _ in range(present):
        cell.place(Cube(), region, rng)
    took = []
    for _ in range(times):
        cube = Cube()
        start = time.perf_counter()
        name = cell.place(cube, region, rng)
        took.append(time.perf_counter() - start)
        cell.remove(name)
    return statistics.median(took)


def memory(times: int = 1000) -> float:
    """Give by how much memory grows while objects come and go [bytes per object]."""

    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")

    cell = Cell()
    before = 0
    for i in range(times + times // 5):
        if i == times // 5:  # by now allocators have what they need
            before = resident()
        cell.remove(cell.add(Cube(), pose((1.0, 0.0, 0.025))))
    return (resident() - before) / times


def snapshot() -> tuple[float, float, float]:
    """Time saving and restoring a station in mid-motion; medians [s], and the size [bytes]."""
    station = build_station()
    station.cell.add(Cube(), pose((0.3, 0.1, 1.04)))
    station.arm.move_to_pose(pointing_down((0.3, 0.1, 1.055)))
    station.cell.step(300)
    saved, restored = [], []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "snapshot.json"
        for _ in range(9):
            start = time.perf_counter()
            save_snapshot(path, station.get_state())
            saved.append(time.perf_counter() - start)
            start = time.perf_counter()
            station.set_state(load_snapshot(path))
            restored.append(time.perf_counter() - start)
        return statistics.median(saved), statistics.median(restored), path.stat().st_size


def rows() -> list[tuple[str, str, str]]:
    """Give the figures: what, how much, beside what."""
    whole, alone = control_step()
    table = [
        (
            "control step (reference, control, physics, contacts)",
            f"{1e6 * whole:.1f} us",
            f"{whole / alone:.2f} x mj_step, {1e6 * alone:.1f} us (at most 2.0)",
        )
    ]
    both, step = coming_and_going()
    table.append(
        ("insertion and removal of an object that was here before", f"{1e3 * both:.1f} ms",
         f"{both / step:.0f} x mj_step, {1e6 * step:.1f} us (at most 350)")
    )  # fmt: skip
    for present in (1, 20):
        added, removed, compiled = insertion(present - 1)
        beside = f"x PyMJCF's compile, {1e3 * compiled:.1f} ms"
        table += [
            (f"insertion, {present} free objects present", f"{1e3 * added:.1f} ms",
             f"{added / compiled:.2f} {beside}"),
            (f"removal, {present} free objects present", f"{1e3 * removed:.1f} ms",
             f"{removed / compiled:.2f} {beside}"),
        ]  # fmt: skip
    table.append(("placing among 12 others", f"{1e3 * placing(12):.1f} ms", ""))
    table.append(
        ("memory, 1,000 objects that come and go", f"{memory():.0f} bytes each", "(0 is flat)")
    )
    saved, restored, size = snapshot()
    table.append(
        ("snapshot of a station: save, restore", f"{1e3 * saved:.1f} ms, {1e3 * restored:.1f} ms",
         f"{size / 1e3:.0f} kB")
    )  # fmt: skip
    return table


def main() -> None:
    """Print the figures."""
    for row in rows():
        print(" | ".join(row))


if __name__ == "__main__":
    main()
