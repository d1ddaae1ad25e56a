"""Inverse kinematics by other packages, where they are installed, on the same poses.

Both are differential: iterated with full steps until the pose is met or `STEPS` are spent.
"""

import importlib.util
import time
from collections.abc import Callable, Iterable

import numpy as np
import pinocchio as pin

from bt_manip.robots import Robot

STEPS = 100
TOLERANCE = 1e-6  # [m] and [rad]

Solver = Callable[[pin.SE3, np.ndarray], np.ndarray]


def peers(robot: Robot) -> Iterable[tuple[str, Solver]]:
    """Give the solvers that can be imported, by name."""
    available = {
        name for name in ("pink", "mink", "qpsolvers", "daqp") if importlib.util.find_spec(name)
    }
    if {"pink", "qpsolvers", "daqp"} <= available:
        yield "pin-pink, iterated", pink_solver(robot)
    if {"mink", "qpsolvers", "daqp"} <= available:
        yield "mink, iterated", mink_solver(robot)


def measure(
    robot: Robot, solve: Solver, targets: list[pin.SE3], starts: Iterable[np.ndarray]
) -> tuple[int, np.ndarray]:
    """Count what is solved inside the limits, by our forward kinematics, and take times [ms]."""
    model, solved, times = robot.make_model(), 0, []
    for T, q0 in zip(targets, starts, strict=True):
        begun = time.thread_time()
        q = solve(T, q0)
        times.append(1e3 * (time.thread_time() - begun))
        solved += error(model.pose(q), T) <= TOLERANCE and model.limits.contain(q, 1e-9)
    return solved, np.array(times)


def error(T: pin.SE3, target: pin.SE3) -> float:
    """Give the larger of distance [m] and angle [rad]."""
    T_td = T.actInv(target)
    return float(max(np.linalg.norm(T_td.translation), np.linalg.norm(pin.log3(T_td.rotation))))


def pink_solver(robot: Robot) -> Solver:
    """Iterate Pink."""
    import pink

    model = robot.make_model()
    frame = model.model.frames[model.tool_frame_id].name
    limit = pink.limits.ConfigurationLimit(model.model, config_limit_gain=1.0)
    task = pink.tasks.FrameTask(frame, position_cost=1.0, orientation_cost=1.0)

    def solve(T: pin.SE3, q0: np.ndarray) -> np.ndarray:
        configuration = pink.Configuration(model.model, model.data, q0)
        task.set_target(T)
        for _ in range(STEPS):
            if error(configuration.get_transform_frame_to_world(frame), T) <= TOLERANCE:
                break
            try:
                v = pink.solve_ik(configuration, [task], 1.0, solver="daqp", limits=[limit])
            except pink.exceptions.PinkError:
                break
            configuration.integrate_inplace(v, 1.0)
        return configuration.q

    return solve


def mink_solver(robot: Robot) -> Solver:
    """Iterate Mink."""
    import mink

    mj_model, site = robot.mj_model, robot.tool_site.full_identifier
    limit = mink.ConfigurationLimit(mj_model, gain=0.95)
    task = mink.FrameTask(site, "site", position_cost=1.0, orientation_cost=1.0)

    def solve(T: pin.SE3, q0: np.ndarray) -> np.ndarray:
        qpos = mj_model.qpos0.copy()
        qpos[robot.qpos_adr] = q0
        configuration = mink.Configuration(mj_model, qpos)
        task.set_target(mink.SE3.from_matrix(T.homogeneous))
        for _ in range(STEPS):
            found = configuration.get_transform_frame_to_world(site, "site")
            if error(pin.SE3(found.as_matrix()), T) <= TOLERANCE:
                break
            try:
                v = mink.solve_ik(configuration, [task], 1.0, "daqp", limits=[limit])
            except mink.MinkError:
                break
            configuration.integrate_inplace(v, 1.0)
        return configuration.q[robot.qpos_adr]

    return solve
