"""Motion: inverse kinematics and planning of the Panda, processor time in ms.

``python -m benchmarks motion``, or ``python -m benchmarks.bench_motion 10000`` for more poses. The
last column holds the requirement, or the same measurement of another implementation.
"""

import sys
import time
from collections.abc import Callable, Iterable

import numpy as np
import pinocchio as pin

from benchmarks import ik_peers
from bt_manip import spatial
from bt_manip.arm import Arm
from bt_manip.exceptions import MotionError
from bt_manip.grippers import TwoFingerGripper
from bt_manip.kinematics import IKProblem, IKResult, InverseKinematics, PoseTarget, PositionTarget
from bt_manip.planning import ArcTo, LineTo
from bt_manip.robots import Robot, RobotModel, compile_alone, panda

POSES = 2000
Row = tuple[str, str, str]


def rows(poses: int = POSES) -> list[Row]:
    """Measure everything.

    Args:
        poses: Number of poses for inverse kinematics.
    """
    robot = Robot(panda(), gripper=TwoFingerGripper)
    compile_alone(robot)
    return [
        *inverse_kinematics_rows(robot.make_model(), poses),
        *problem_rows(robot.make_model()),
        *free_rotation_rows(robot.make_model()),
        *peer_rows(robot),
        *planning_rows(Arm(robot)),
    ]


def inverse_kinematics_rows(model: RobotModel, poses: int) -> Iterable[Row]:
    """Measure success and time of inverse kinematics, at 1e-6 m and 1e-6 rad."""
    begun = time.thread_time()
    ik = InverseKinematics(model)
    yield "IK: preparing", f"{1e3 * (time.thread_time() - begun):.1f}", ""

    rng = np.random.default_rng(77)
    lower, upper = model.limits.lower, model.limits.upper
    goals = rng.uniform(lower, upper, (poses, model.nq))
    starts = rng.uniform(lower, upper, goals.shape)
    targets = [model.pose(q) for q in goals]

    found, times = timed(lambda T: ik.solve(T, model.home), targets)
    yield _solved("IK from home", model, found, times, "100 %, 0.30 / 3; prototype 0.41 / 3.5")
    found, times = timed(ik.solve, targets, starts)
    yield _solved("IK from random initial guesses", model, found, times, "100 %")

    near = np.clip(goals + rng.uniform(-0.1, 0.1, goals.shape), lower, upper)
    found, times = timed(ik.follow, [model.pose(q) for q in near], goals)
    yield _solved("IK following", model, found, times, "100 %, 0.15")
    step = max(np.abs(r.q - q).max() for r, q in zip(found, goals, strict=True))
    yield "IK following: largest joint step", f"{step:.3f} rad", "0.2 rad"

    beyond = [pin.SE3(T.rotation, 3.0 * T.translation + np.array([0.0, 0.0, 1.0])) for T in targets]
    found, times = timed(lambda T: ik.solve(T, model.home), beyond)
    refused = np.array([not r.solved and r.iterations == 0 for r in found])
    times = times[refused] if refused.any() else times
    yield "IK beyond the reach: refused", _times(times), "1 at most"
    folded = [pin.SE3(T.rotation, 0.1 * T.translation) for T in targets[: poses // 10]]
    found, times = timed(lambda T: ik.solve(T, model.home), folded)
    unsolved = times[[not r.solved for r in found]]
    yield "IK unsolved otherwise: longest", f"{unsolved.max(initial=0.0):.1f}", "40 at most"

    places = rng.uniform([0.3, -0.3, 0.05], [0.6, 0.3, 0.5], (poses // 10, 3))
    turns = 0.5 * np.pi * np.arange(4)
    yaws = rng.uniform(-np.pi, np.pi, len(places))
    grips = [
        [spatial.pointing_down(p, yaw + turn) for turn in turns]
        for p, yaw in zip(places, yaws, strict=True)
    ]
    found, times = timed(lambda Ts: ik.nearest(Ts, model.home, margin=0.05), grips)
    yield _solved("IK nearest of four grips", model, found, times, "")


def problem_rows(model: RobotModel, poses: int = 200) -> Iterable[Row]:
    """Measure problems, from home."""
    ik, rng = InverseKinematics(model), np.random.default_rng(78)
    goals = rng.uniform(model.limits.lower, model.limits.upper, (poses, model.nq))
    elbow = model.model.getFrameId("link4")

    def elbow_of(q: np.ndarray) -> np.ndarray:
        pin.framesForwardKinematics(model.model, model.data, q)
        return model.data.oMf[elbow].translation.copy()

    tools, elbows = [model.pose(q) for q in goals], [elbow_of(q) for q in goals]
    for what, make in (
        ("a position", lambda T, e: IKProblem(targets=PositionTarget("tool", T.translation))),
        (
            "positions of tool and elbow",
            lambda T, e: IKProblem(
                targets=[PositionTarget("tool", T.translation), PositionTarget("link4", e)]
            ),
        ),
        (
            "a pose, the elbow as a cost",
            lambda T, e: IKProblem(
                targets=[PoseTarget("tool", T), PositionTarget("link4", e, weight=1.0)]
            ),
        ),
        (
            "a pose, posture and manipulability",
            lambda T, e: IKProblem(
                targets=PoseTarget("tool", T), posture=model.home, manipulability=0.1
            ),
        ),
    ):
        problems = [make(T, e) for T, e in zip(tools, elbows, strict=True)]
        found, times = timed(lambda problem: ik.solve(problem, model.home), problems)
        yield _solved(f"IK problem: {what}", model, found, times, "")


def free_rotation_rows(model: RobotModel, targets: int = 200) -> Iterable[Row]:
    """Measure targets with free rotations beside solving 32 sampled rotations, from home.

    Positions are random in the box around the workspace, also out of reach; the tool points down,
    anywhere, or within 0.5 rad of down.
    """
    ik, rng = InverseKinematics(model), np.random.default_rng(79)
    drawn = rng.uniform(model.limits.lower, model.limits.upper, (2000, model.nq))
    lower, upper = np.quantile([model.pose(q).translation for q in drawn], [0.02, 0.98], axis=0)
    turns = [pin.utils.rotate("z", 2.0 * np.pi * k / 32) for k in range(32)]
    for what, cone in (("down", 0.0), ("anywhere", 0.0), ("down within 0.5 rad", 0.5)):
        poses = []
        for position in rng.uniform(lower, upper, (targets, 3)):
            T = spatial.pointing_down(position, rng.uniform(-np.pi, np.pi))
            if what == "anywhere":
                T = pin.SE3(spatial.pose((0, 0, 0), rng.normal(size=4)).rotation, position)
            poses.append(T)
        free, times = timed(
            lambda T, cone=cone: ik.solve(
                PoseTarget(ik.tool, T, free_axis="z", cone=cone), model.home
            ),
            poses,
        )
        begun = time.thread_time()
        sampled = []
        for T in poses:
            tilts = cone * np.sqrt(rng.uniform(size=32)) * rng.choice([-1.0, 1.0], size=32)
            rotations = [
                turn @ pin.utils.rotate("x", tilt) @ turns[int(rng.integers(32)) if cone else 0]
                for turn, tilt in zip(turns, tilts, strict=True)
            ]
            sampled.append(
                any([ik.solve(T * pin.SE3(R, np.zeros(3)), model.home).solved for R in rotations])
            )
        per_target = 1e3 * (time.thread_time() - begun) / targets
        solved = np.mean([result.solved for result in free])
        yield (
            f"IK free about the tool's axis, which points {what}",
            f"{100 * solved:.1f} %, {times.mean():.2f} (mean)",
            f"32 rotations: {100 * np.mean(sampled):.1f} %, {per_target:.2f} (mean)",
        )


def peer_rows(robot: Robot, poses: int = 200) -> Iterable[Row]:
    """Measure other packages where they are installed, from home, with the same poses."""
    model = robot.make_model()
    rng = np.random.default_rng(77)
    goals = rng.uniform(model.limits.lower, model.limits.upper, (poses, model.nq))
    targets = [model.pose(q) for q in goals]
    for name, solve in ik_peers.peers(robot):
        if solve is None:
            yield f"IK from home by {name}", "not installed", "pip install 'bt-manip[peers]'"
            continue
        solved, times = ik_peers.measure(robot, solve, targets, [model.home] * poses)
        yield f"IK from home by {name}", f"{solved} of {poses}, {_times(times)}", ""


def planning_rows(arm: Arm, moves: int = 100) -> Iterable[Row]:
    """Measure planning from request to checked trajectory, and following it."""
    rng = np.random.default_rng(5)
    limits = arm.model.limits

    def plan(ask: Callable[[], None], settle: bool = True) -> tuple[float, float] | None:
        begun = time.thread_time()
        try:
            ask()
        except MotionError:
            return None
        taken, duration = time.thread_time() - begun, arm.remaining
        while settle and arm.moving:
            arm.advance(1e-3)
        return 1e3 * taken, duration

    def row(what: str, planned: list[tuple[float, float] | None]) -> Row:
        done = np.array([p for p in planned if p is not None])
        moved = f"moves of {done[:, 1].mean():.2f} s"
        if len(done) < len(planned):
            moved += f", {len(planned) - len(done)} of {len(planned)} refused"
        return what, _times(done[:, 0]), moved

    yield row(
        "plan: to a random configuration",
        [
            plan(lambda q=q: arm.move_to_configuration(q))
            for q in rng.uniform(limits.lower, limits.upper, (moves, arm.model.nq))
        ],
    )
    hovers, lines, lifts = [], [], []
    for x, y, yaw in rng.uniform([0.3, -0.3, -3.1], [0.5, 0.3, 3.1], (moves, 3)):
        above = [spatial.pointing_down([x, y, 0.44], yaw + 0.5 * np.pi * k) for k in range(4)]
        hovers.append(plan(lambda above=above: arm.move_to_pose(above, approach=0.385)))
        T = arm.model.pose(arm.q)
        T_grip = T * pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.385]))
        lines.append(plan(lambda T=T_grip: arm.move_linear(T)))
        lifts.append(plan(lambda T=T: arm.move_linear(T)))
        arm.move_to_pose(spatial.pointing_down([0.6, 0.0, 0.3], yaw))
        while arm.moving:
            arm.advance(1e-3)
    yield row("plan: over a cube, four grips, way down clear", hovers)
    yield row("plan: tool line of 0.385 m, down", lines)
    yield row("plan: tool line of 0.385 m, up", lifts)

    start = spatial.pointing_down([0.4, -0.2, 0.3])
    corners, arcs = [], []
    for x, y, z, yaw in rng.uniform([0.35, 0.0, 0.2, -0.6], [0.5, 0.3, 0.5, 0.6], (moves // 2, 4)):
        end = spatial.pointing_down([x, y, z], yaw)
        for planned, steps in (
            (corners, [LineTo(spatial.pointing_down([0.5, 0.0, 0.35])), LineTo(end)]),
            (arcs, [ArcTo([0.55, 0.0, 0.3], end)]),
        ):
            arm.reset(arm.ik.nearest(start, arm.model.home).q)
            planned.append(plan(lambda steps=steps: arm.move_path(steps, blend=0.05)))
    yield row("plan: tool path of two lines, blended by 0.05 m", corners)
    yield row("plan: tool path on an arc", arcs)

    turned, stopped = [], []
    for q in rng.uniform(limits.lower, limits.upper, (moves, arm.model.nq)):
        turned.append(plan(lambda q=q: arm.move_to_configuration(q), settle=False))
        for _ in range(150):
            arm.advance(1e-3)
        if rng.random() < 0.5:
            stopped.append(plan(arm.stop))
    yield row("plan: redirect in the middle of a motion", turned)
    yield row("plan: stop", stopped)

    arm.reset()
    arm.move_to_configuration(arm.model.home + 0.5)
    steps = int(arm.remaining / 1e-3) - 1
    begun = time.thread_time()
    for _ in range(steps):
        arm.advance(1e-3)
    microseconds = 1e6 * (time.thread_time() - begun) / steps
    yield "advance the reference by one step", f"{microseconds:.2f} us", "2 us at most"


def timed(ask: Callable[..., IKResult], *inputs: Iterable) -> tuple[list[IKResult], np.ndarray]:
    """Return the results for all inputs and their times [ms]."""
    found, times = [], []
    for arguments in zip(*inputs, strict=True):
        begun = time.thread_time()
        found.append(ask(*arguments))
        times.append(1e3 * (time.thread_time() - begun))
    return found, np.array(times)


def _solved(
    what: str, model: RobotModel, found: list[IKResult], times: np.ndarray, beside: str
) -> Row:
    good = sum(r.solved and model.limits.contain(r.q) for r in found)
    return what, f"{good} of {len(found)}, {_times(times)}", beside


def _times(times: np.ndarray) -> str:
    return f"{np.median(times):.3f} / {np.percentile(times, 99):.2f} (median / p99)"


if __name__ == "__main__":
    for what, measured, beside in rows(int(sys.argv[1]) if len(sys.argv) > 1 else POSES):
        print(f"{what:48} {measured:42} {beside}")
