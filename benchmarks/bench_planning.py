"""Planning around obstacles, executed in physics; processor time in ms.

``python -m benchmarks planning``; ``python -m benchmarks.bench_planning 200`` takes as many seeds
and scenes as are asked for, which takes minutes.
"""

import sys
import time
from collections.abc import Iterator

import mujoco
import numpy as np

from benchmarks.scenes import Planned, random_scene, wall
from bt_manip.motion import MotionError
from bt_manip.motion.planning.edges import line

SOME = 20
FINE = 2e-3  # [rad]
Row = tuple[str, str, str]


def rows(count: int = SOME) -> list[Row]:
    """Measure everything, with as many seeds, scenes and pushes as are asked for."""
    return [*wall_rows(count), *scene_rows(count), *halt_rows(count), *push_rows(count)]


def wall_rows(seeds: int) -> Iterator[Row]:
    """Plan from one side of a wall to the other."""
    planned, left, right = wall()
    arm = planned.arm
    start = next(
        found.q for found in arm.ik.solutions(left, arm.model.home, margin=0.05)
        if not arm.world.near(found.q)
    )  # fmt: skip
    times, free = [], 0
    for seed in range(seeds):
        arm.reset(start)
        begun = time.thread_time()
        try:
            arm.move_to_pose(right, rng=np.random.default_rng(seed))
        except MotionError:
            continue
        times.append(1e3 * (time.thread_time() - begun))
        free += not any(arm.world.near(q) for q in _fine(drive_reference(planned)))
    middle, most = np.percentile(times, [50, 95])
    yield "wall: solved, and free at steps of 0.002 rad", f"{free} of {seeds}", "all"
    yield (
        "wall: request to checked trajectory",
        f"{middle:.0f} / {most:.0f} (median / 95 %)",
        ("100 / 250; OMPL 58 with shortening"),
    )


def scene_rows(scenes: int) -> Iterator[Row]:
    """Drive from start to goal among random obstacles."""
    reached, refused, touched, saturated = 0, 0, 0, 0
    errors, durations, times = [], [], []
    for seed in range(scenes):
        planned, start, goal = random_scene(seed)
        put(planned, start)
        begun = time.thread_time()
        try:
            planned.arm.move_to_configuration(goal, rng=np.random.default_rng(seed))
        except MotionError:
            refused += 1
            continue
        times.append(1e3 * (time.thread_time() - begun))
        durations.append(planned.arm.remaining)
        worst = 0.0
        meant = True
        while planned.arm.moving:
            planned.cell.step()
            worst = max(worst, float(np.abs(planned.robot.q - planned.arm.q).max()))
            meant &= not planned.cell.data.ncon
        touched += not meant
        saturated += planned.control.saturated_steps > 0
        errors.append(worst)
        reached += np.array_equal(planned.arm.q, goal) and worst < 0.01
    middle, most = np.percentile(times, [50, 95])
    yield (
        "random scenes: reached in physics",
        f"{reached} of {scenes}, {refused} refused",
        ("190 of 200"),
    )
    yield "random scenes: planning", f"{middle:.0f} / {most:.0f} (median / 95 %)", ""
    yield "random scenes: contacts, saturated", f"{touched}, {saturated} scenes", "0, 0"
    yield "random scenes: largest tracking error", f"{1e3 * max(errors):.2f} mrad", "2 mrad"
    yield "random scenes: duration", f"{np.median(durations):.2f} s (median)", ""


def halt_rows(halts: int) -> Iterator[Row]:
    """Stop at random moments of the motions around the wall."""
    planned, left, right = wall()
    arm, limits = planned.arm, planned.arm.model.limits
    rng = np.random.default_rng(3)
    off, late, outside = [], [], 0
    start = arm.ik.nearest(left, arm.model.home, margin=0.05).q
    for halt in range(halts):
        arm.reset(start)
        arm.move_to_pose(right, rng=np.random.default_rng(halt % 10))
        way = _fine(drive_reference(planned), 5e-4)
        arm.reset(start)
        arm.move_to_pose(right, rng=np.random.default_rng(halt % 10))
        for _ in range(int(rng.uniform(0.05, 0.95) * arm.remaining / 1e-3)):
            arm.advance(1e-3)
        shortest = float((np.abs(arm.v) / limits.acceleration).max())
        a = arm.a_ref
        arm.stop()
        late.append(arm.remaining - shortest)
        while arm.moving:
            arm.advance(1e-3)
            off.append(float(np.abs(way - arm.q).max(axis=1).min()))
            outside += bool((np.abs(arm.a - a) > 1e-3 * limits.jerk * 1.000001).any())
            outside += bool((np.abs(arm.a) > limits.acceleration * 1.000001).any())
            a = arm.a_ref
    yield "halts: farthest off the path", f"{1e3 * max(off):.2f} mrad of {halts} halts", "1 mrad"
    yield "halts: steps outside of a limit", f"{outside}", "0"
    yield (
        "halts: longer than each joint alone would take",
        (f"{1e3 * np.median(late):.0f} / {1e3 * max(late):.0f} ms (median / most)"),
        "",
    )


def push_rows(pushes: int) -> Iterator[Row]:
    """Push the hand with 50 N in random directions, in the middle of motions."""
    planned, left, right = wall()
    arm, hand = planned.arm, planned.cell.body_id("panda/hand")
    start = arm.ik.nearest(left, arm.model.home, margin=0.05).q
    rng = np.random.default_rng(4)
    noticed, false = [], 0
    for push in range(pushes):
        put(planned, start)
        arm.move_to_pose(right, rng=np.random.default_rng(push % 10))
        planned.cell.step(int(rng.uniform(0.05, 0.85) * arm.remaining / 1e-3))
        false += bool(arm.fault)
        direction = rng.normal(size=3)
        force = 50.0 * direction / np.linalg.norm(direction)
        planned.cell.data.xfrc_applied[hand][:3] = force
        for step in range(1, 51):
            planned.cell.step()
            if arm.fault:
                noticed.append(step)
                break
        planned.cell.data.xfrc_applied[hand][:3] = 0.0
    soon = sum(step <= 20 for step in noticed)
    yield (
        "pushes of 50 N noticed within 20 ms",
        (f"{soon} of {pushes}, latest {max(noticed)} ms, {false} false"),
        "all, none false",
    )


def put(planned: Planned, q: np.ndarray) -> None:
    """Put the arm somewhere, at rest."""
    data = planned.cell.data
    data.qvel[:] = data.qacc[:] = 0.0
    planned.robot.set_configuration(q)
    mujoco.mj_forward(planned.cell.model, data)
    planned.control.reset()
    planned.arm.reset(q)


def drive_reference(planned: Planned) -> np.ndarray:
    """Advance the reference to its end; give all configurations."""
    found = [planned.arm.q_ref]
    while planned.arm.moving:
        planned.arm.advance(1e-3)
        found.append(planned.arm.q_ref)
    return np.array(found)


def _fine(q: np.ndarray, step: float = FINE) -> np.ndarray:
    return np.vstack([q[:1], *(line(a, b, step) for a, b in zip(q, q[1:], strict=False))])


if __name__ == "__main__":
    for what, measured, beside in rows(int(sys.argv[1]) if len(sys.argv) > 1 else SOME):
        print(f"{what:56} {measured:48} {beside}")
