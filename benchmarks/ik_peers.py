"""Inverse kinematics by other packages, where they are installed, with the same poses.

Pink and mink solve differential inverse kinematics: they are iterated with full steps until the
pose is reached, at most `STEPS` times. Robotics Toolbox's `ik_LM` restarts by itself; the model is
converted joint by joint. The extra ``peers`` installs them all.
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


def peers(robot: Robot) -> Iterable[tuple[str, Solver | None]]:
    """Yield the solvers by name; None for a package that is not installed."""
    for name, modules, make in (
        ("pin-pink, iterated", ("pink", "qpsolvers", "daqp"), pink_solver),
        ("mink, iterated", ("mink", "qpsolvers", "daqp"), mink_solver),
        ("roboticstoolbox, ik_LM", ("roboticstoolbox",), toolbox_solver),
    ):
        installed = all(importlib.util.find_spec(module) for module in modules)
        yield name, make(robot) if installed else None


def measure(
    robot: Robot, solve: Solver, targets: list[pin.SE3], starts: Iterable[np.ndarray]
) -> tuple[int, np.ndarray]:
    """Return the number of poses solved inside the limits, and the times [ms]."""
    model, solved, times = robot.make_model(), 0, []
    for T, q0 in zip(targets, starts, strict=True):
        begun = time.thread_time()
        q = solve(T, q0)
        times.append(1e3 * (time.thread_time() - begun))
        solved += error(model.pose(q), T) <= TOLERANCE and model.limits.contain(q, 1e-9)
    return solved, np.array(times)


def error(T: pin.SE3, target: pin.SE3) -> float:
    """Return the larger of distance [m] and angle [rad]."""
    T_td = T.actInv(target)
    return float(max(np.linalg.norm(T_td.translation), np.linalg.norm(pin.log3(T_td.rotation))))


def pink_solver(robot: Robot) -> Solver:
    """Return a solver that iterates Pink."""
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
    """Return a solver that iterates mink."""
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


def toolbox_solver(robot: Robot) -> Solver:
    """Return Robotics Toolbox's Levenberg-Marquardt in C++, with its own restarts."""
    import roboticstoolbox as rtb
    from spatialmath import SE3

    model = robot.make_model()
    parts = []
    for joint, placement in zip(model.model.joints, model.model.jointPlacements, strict=True):
        if joint.idx_q < 0:
            continue
        if joint.shortname() != "JointModelRZ":
            raise ValueError(f"{joint.shortname()} is not translated to Robotics Toolbox")
        lower, upper = model.limits.lower[joint.idx_q], model.limits.upper[joint.idx_q]
        parts += [
            rtb.ET.SE3(SE3(placement.homogeneous, check=False)),
            rtb.ET.Rz(jindex=joint.idx_q, qlim=[lower, upper]),
        ]
    tool = model.model.frames[model.tool_frame_id].placement
    chain = rtb.ETS([*parts, rtb.ET.SE3(SE3(tool.homogeneous, check=False))])

    def solve(T: pin.SE3, q0: np.ndarray) -> np.ndarray:
        # Its error is half the squared norm of position and angle.
        found = chain.ik_LM(
            T.homogeneous, q0=q0, tol=0.1 * TOLERANCE**2, joint_limits=True, method="chan"
        )
        return np.array(found.q if hasattr(found, "q") else found[0])

    return solve
