"""Measurement of the travel of a gripper's fingers on its model."""

import copy
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin
from numpy.polynomial import Polynomial

from bt_manip.cell import escaped_name, literal_name
from bt_manip.grippers import BodySurface, FingerTravel, TwoFingerParameters, travel_digests
from bt_manip.robots import Robot, RobotDescription, RobotError, site_pose
from bt_manip.toml import read_part, write_fields

from .bench import BEHIND, STOPS, FingerBench, Sweep, ancestors, naming

_TENDON = int(mujoco.mjtObj.mjOBJ_TENDON)
_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)

_DEGREES = (1, 5, 7)  # of the fitted polynomials; the first accurate one is used
_ACCURATE = 2e-5  # [m] error of an accurate fit of the travel
_RESIDUAL = 1e-3  # [m] maximum error of the fit
_SYMMETRIC = 3e-4  # [m] offset of a slide that is neglected
_DIGITS = 9  # of the closing direction
_CENTRED = 1e-3  # [m] distance of the pads' centre from the tool that is neglected
_MIN_TRAVEL = 1e-3  # [m] minimum travel of the opening
_MOVES = 1e-6  # [m] or [rad] minimum motion of a joint that moves with the fingers
_MASS_RATIO = 4.0  # of the mass to the least: the position loop of lighter fingers is unstable
_FIXED = 0.1  # motion of a fixed finger, relative to the opening's, at most
_ACCURATE_EFFORT = 0.01  # error of an accurate fit, relative to the largest spring effort
_NO_EFFORT = 1e-4  # [N] or [N m] spring effort that is neglected


def measured(description: RobotDescription) -> RobotDescription:
    """Return a robot's description with the measured travel of its gripper's fingers.

    Use it for models that are made at run time; ``bt-manip robot measure`` writes the same values
    into the description's file.

    Args:
        description: The description, with any or no travel.

    Raises:
        RobotError: If its gripper has no two fingers, or the model does not fit the description.
    """
    gripper = description.gripper
    if gripper is None:
        raise RobotError(f"{description.where} has no gripper")
    given = {key: value for key, value in gripper.parameters.items() if key != "travel"}
    gripper = replace(gripper, parameters=given)
    parameters = read_part(TwoFingerParameters, gripper.read(description.name))
    assert parameters is not None  # otherwise the table raises an error
    robot = Robot(replace(description, gripper=gripper))
    joints, fingers = (
        tuple(robot.find(kind, name).full_identifier for name in names)
        for kind, names in (("joint", parameters.joints), ("body", parameters.fingers))
    )
    arm_joints = [joint.full_identifier for joint in robot.arm_joints]
    bench = FingerBench(_with_joints(robot.alone, joints, parameters), arm_joints)
    if parameters.motor is None:
        found = bench.motor_of([bench.model.joint(name).id for name in joints])
        motor = found and found[1]
    else:
        tendon = robot.gripper_root.find("tendon", escaped_name(parameters.motor))
        motor = (tendon or robot.find("joint", parameters.motor)).full_identifier
    site, prefix = robot.tool_site, robot.gripper_root.full_identifier

    def local(name: str) -> str:
        return literal_name(name.removeprefix(prefix))

    with naming(f"robot '{description.name}'"):
        travel = measure_travel(
            bench,
            FingerNames(joints, (fingers[0], fingers[1]), motor),
            tool_body=site.parent.full_identifier,
            T_bt=site_pose(robot.alone, site),
        )
    travel = replace(
        travel,
        motor=None if motor is None else local(motor),
        joints=tuple(map(local, travel.joints)),
        digests=travel_digests(robot, parameters),
    )
    gripper = replace(gripper, parameters=given | {"travel": write_fields(travel)})
    return replace(description, gripper=gripper)


def _with_joints(
    alone: mujoco.MjModel, joints: Iterable[str], parameters: TwoFingerParameters
) -> mujoco.MjModel:
    """Return the model with the described armature and dry friction of the mechanism's joints."""
    if parameters.armature is None and parameters.frictionloss is None:
        return alone
    model = copy.copy(alone)
    bases = {int(model.body_parentid[model.jnt_bodyid[model.joint(name).id]]) for name in joints}
    below = [j for j in range(model.njnt) if bases & {*ancestors(model, model.jnt_bodyid[j])[1:]}]
    dofs = model.jnt_dofadr[below]
    if parameters.frictionloss is not None:
        model.dof_frictionloss[dofs] = parameters.frictionloss
    if parameters.armature is not None:
        model.dof_armature[dofs] = parameters.armature
        mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


class FingerNames(NamedTuple):
    """Full names of a gripper's parts in the compiled model.

    Attributes:
        joints: The joints that the fingers follow: one for each, or one for both.
        fingers: The finger bodies.
        motor: The joint or tendon moved by the only motor; None with one motor for each joint.
    """

    joints: tuple[str, ...]
    fingers: tuple[str, str]
    motor: str | None


class _Finger(NamedTuple):
    """A finger during the sweep of its joint, in the tool frame.

    Attributes:
        joint: Id of its joint.
        sweep: The sweep.
        poses: Poses of its body.
        sections: Corners of its surface between the tool and the tips.  # m x (k, 3)
    """

    joint: int
    sweep: Sweep
    poses: list[pin.SE3]
    sections: list[np.ndarray]

    def inner_face(self, outwards: np.ndarray) -> np.ndarray:
        """Return the coordinates of the inner face along a direction [m], NaN where unknown."""
        faces = np.array([(points @ outwards).min(initial=np.inf) for points in self.sections])
        return np.where(np.isinf(faces), np.nan, faces)  # (m,)


class _Drive(NamedTuple):
    """Motion of the fingers by their motors; other attributes as in `FingerTravel`.

    Attributes:
        widths: Openings, increasing [m].  # (m,)
        polynomials: Coefficients of s(q) for each finger, the constant first.
        holding: Coefficients of each motor's effort against springs as a function of q.
        ratios: Velocity of each finger's joint per velocity of the motor.  # (2,)
        qpos: Positions of all joints of the model at `widths`.  # (m, nq)
        direct: Whether the fingers are slides with a motor each.
    """

    widths: np.ndarray
    qpos: np.ndarray
    polynomials: tuple[np.ndarray, np.ndarray]
    holding: tuple[np.ndarray, np.ndarray]
    ratios: np.ndarray
    centre: tuple[float, float]
    direct: bool = False


def measure_travel(
    bench: FingerBench, names: FingerNames, *, tool_body: str, T_bt: pin.SE3
) -> FingerTravel:
    """Measure the travel of two fingers by moving the gripper over its range without load.

    Args:
        bench: The robot, compiled on its own.
        names: The gripper's joints, fingers and motor.
        tool_body: Full name of the body that carries the tool.
        T_bt: Pose of the tool in that body; its z axis is the approach direction.

    Raises:
        RobotError: If the joints have no range or do not move the fingers, or an opening does not
            determine their positions.
    """
    model = bench.model
    joints = [int(model.joint(name).id) for name in names.joints]
    unlimited = [n for n, j in zip(names.joints, joints, strict=True) if not model.jnt_limited[j]]
    if unlimited:
        raise RobotError(f"gripper joints without a range: {', '.join(unlimited)}")
    if names.motor is None:
        sweeps = [bench.sweep(joints[0], joints[1:]), bench.sweep(joints[1], joints[:1])]
    else:
        sweeps = [bench.sweep(joints[0])] * 2
    fingers = []
    for name, joint, sweep in zip(names.fingers, (joints[0], joints[-1]), sweeps, strict=True):
        T_wt = [bodies[int(model.body(tool_body).id)] * T_bt for bodies in sweep.bodies]
        surface = BodySurface(model, int(model.body(name).id))
        fingers.append(_finger(surface, name, joint, sweep, T_wt))
    closing = _closing(fingers)
    measure = _coupled if sweeps[0] is sweeps[1] else _independent
    drive = measure(bench, fingers, closing, names)
    return _travel(bench, names.motor, closing, drive)


def _finger(
    surface: BodySurface, name: str, joint: int, sweep: Sweep, T_wt: list[pin.SE3]
) -> _Finger:
    """Return a finger in a sweep, given the poses of the tool in the world."""
    poses = [T.inverse() * b[surface.body] for T, b in zip(T_wt, sweep.bodies, strict=True)]
    sections = [surface.beyond(T, -BEHIND) for T in poses]
    if any(map(len, sections)):
        return _Finger(joint, sweep, poses, sections)
    heights = np.concatenate([surface.beyond(T, -np.inf) for T in poses])[:, 2]
    if not len(heights):
        raise RobotError(f"finger '{name}' has no geom that collides")
    raise RobotError(
        f"the tool frame is not between the fingers: along its z axis, '{name}' is "
        f"{-1e3 * heights.max():.1f} mm behind it"
    )


def _closing(fingers: Sequence[_Finger]) -> np.ndarray:
    """Return the direction from the second to the first finger along their relative motion."""
    first, second = (_motion_at_tool(finger.poses) for finger in fingers)
    axis = first + np.sign(first @ second) * second
    length = float(np.linalg.norm(axis)) or 1.0
    centres = [np.concatenate(finger.sections).mean(axis=0)[:2] for finger in fingers]
    sign = 1.0 if axis @ (centres[0] - centres[1]) > 0.0 else -1.0
    return np.array([*np.round(sign * axis / length, _DIGITS), 0.0]) + 0.0


def _motion_at_tool(poses: Sequence[pin.SE3]) -> np.ndarray:
    """Sum the displacements of a finger's material points that pass through the tool [m]."""
    return np.sum([(b * a.inverse()).translation[:2] for a, b in pairwise(poses)], axis=0)


def _monotonic(travel: np.ndarray) -> np.ndarray:
    """Return the indices of the longest strictly monotonic part, from closed to open."""
    signs = np.sign(np.diff(travel))
    parts = np.split(np.arange(len(signs)), np.flatnonzero(signs[1:] != signs[:-1]) + 1)
    moving = [part for part in parts if abs(signs[part[0]]) == 1.0]
    best = max(moving, key=lambda part: (len(part), -signs[part[0]], part[0]), default=parts[0])
    rows = np.append(best, best[-1] + 1)
    return rows if signs[best[0]] > 0.0 else rows[::-1]


def _coupled(
    bench: FingerBench, fingers: Sequence[_Finger], closing: np.ndarray, names: FingerNames
) -> _Drive:
    """Measure fingers with one motor."""
    model, sweep = bench.model, fingers[0].sweep
    first, second = fingers[0].inner_face(closing), -fingers[1].inner_face(-closing)
    rows = _monotonic(first - second)
    first, second = first[rows], second[rows]
    opening = first - second
    _check_opening(opening, names.joints[0], names.fingers)
    q = sweep.qpos[rows][:, model.jnt_qposadr[[finger.joint for finger in fingers]]]
    if np.ptp(q[:, 1]) < _MOVES:
        raise RobotError(
            f"one motor moves both fingers, but nothing in the model couples joint "
            f"'{names.joints[1]}' to '{names.joints[0]}'; an equality does, or leave out 'motor'"
        )
    assert names.motor is not None
    motor = _motor_positions(model, names.motor, sweep)[rows]
    ratios = np.ones(2)
    if np.ptp(motor) > 0.0:
        ratios = np.array([np.polyfit(motor, column, 1)[0] for column in q.T])
    work = _spring_work(bench, sweep, rows, q[:, 0]) * ratios[0]
    fixed = np.ptp(second) < _FIXED * np.ptp(opening)
    slope = 0.5 if fixed else 0.0
    offset = float((0.5 * (first + second) - slope * opening).mean())
    return _Drive(
        opening,
        sweep.qpos[rows],
        (_fit(q[:, 0], 0.5 * opening), _fit(q[:, 1], 0.5 * opening)),
        (work, np.zeros(1)),
        ratios,
        (offset if fixed or abs(offset) > _CENTRED else 0.0, slope),
    )


def _motor_positions(model: mujoco.MjModel, motor: str, sweep: Sweep) -> np.ndarray:
    """Return the positions of a joint or tendon."""  # (m,)
    tendon = mujoco.mj_name2id(model, _TENDON, motor)
    if tendon >= 0:
        return sweep.tendons[:, tendon]
    return sweep.qpos[:, model.jnt_qposadr[model.joint(motor).id]]


def _independent(
    bench: FingerBench, fingers: Sequence[_Finger], closing: np.ndarray, names: FingerNames
) -> _Drive:
    """Measure fingers with one motor each."""
    model = bench.model
    faces, rows, qs, holding = [], [], [], []
    for finger, name, sign in zip(fingers, names.fingers, (1.0, -1.0), strict=True):
        face = sign * finger.inner_face(sign * closing)
        row = _monotonic(sign * face)
        q = finger.sweep.qpos[row, model.jnt_qposadr[finger.joint]]
        _check_opening(face[row], model.joint(finger.joint).name, [name])
        faces.append(face[row])
        rows.append(row)
        qs.append(q)
        holding.append(_spring_work(bench, finger.sweep, row, q))
    first, second = faces
    centre = 0.5 * float(first[0] + second[0])
    s = [first - centre, centre - second]
    slides = [_slide(model, f.joint, q, t) for f, q, t in zip(fingers, qs, s, strict=True)]
    direct = None not in slides and not any(work.any() for work in holding)
    if direct:
        polynomials = [np.array(slide) for slide in slides]
        ranges = model.jnt_range[[finger.joint for finger in fingers]]
        ends = [p[0] + p[1] * limits for p, limits in zip(polynomials, ranges, strict=True)]
        lower, upper = np.sort(ends).T
        grid = np.array([lower.max(), upper.min()])
    else:
        polynomials = [_fit(q, t) for q, t in zip(qs, s, strict=True)]
        grid = np.linspace(max(t[0] for t in s), min(t[-1] for t in s), STOPS)
    qpos = np.repeat(fingers[0].sweep.qpos[rows[0][:1]], len(grid), axis=0)
    for finger, row, t, polynomial in zip(fingers, rows, s, polynomials, strict=True):
        for moved in model.jnt_qposadr[list(bench.coupled(finger.joint))]:
            qpos[:, moved] = np.interp(grid, t, finger.sweep.qpos[row, moved])
        if direct:
            qpos[:, model.jnt_qposadr[finger.joint]] = (grid - polynomial[0]) / polynomial[1]
    return _Drive(
        2.0 * grid,
        qpos,
        (polynomials[0], polynomials[1]),
        (holding[0], holding[1]),
        np.ones(2),
        (centre if abs(centre) > _CENTRED else 0.0, 0.0),
        direct,
    )


def _travel(
    bench: FingerBench, motor: str | None, closing: np.ndarray, drive: _Drive
) -> FingerTravel:
    """Return the travel, with friction at half the opening, and mass there or near the least."""
    model, widths = bench.model, drive.widths
    moving = [j for j in bench.joints if np.ptp(drive.qpos[:, model.jnt_qposadr[j]]) > _MOVES]
    at_q, at_v = model.jnt_qposadr[moving], model.jnt_dofadr[moving]
    middle = len(widths) // 2
    before, after = max(middle - 1, 0), min(middle + 1, len(widths) - 1)
    q = drive.qpos[:, at_q]
    dq = (q[after] - q[before]) / (0.5 * (widths[after] - widths[before]))
    data = mujoco.MjData(model)
    data.qpos[:] = drive.qpos[middle]
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    M, rates = full[np.ix_(at_v, at_v)], np.gradient(q, 0.5 * widths, axis=0)
    least = 0.5 * float(((rates @ M) * rates).sum(axis=1).min())
    return FingerTravel(
        motor=motor,
        open_width=float(widths[-1]),
        min_width=max(float(widths[0]), 0.0),
        polynomials=tuple(map(_numbers, drive.polynomials)),
        holding=tuple(map(_numbers, drive.holding)),
        ratios=_numbers(drive.ratios),
        mass=0.0 if drive.direct else min(0.5 * float(dq @ M @ dq), _MASS_RATIO * least),
        loss=0.5 * float(dq @ (model.dof_damping[at_v] * dq)),
        friction=0.5 * float(bench.frictionloss[at_v] @ np.abs(dq)),
        joints=tuple(model.joint(j).name for j in moving),
        widths=_numbers(widths),
        positions=tuple(map(_numbers, q.T)),
        closing=_numbers(closing),
        centre=drive.centre,
        digests={},
    )


def _numbers(values: Iterable[float]) -> tuple[float, ...]:
    """Return numbers as they are read from a file, without negative zeros."""
    return tuple(float(value) + 0.0 for value in values)


def _check_opening(opening: np.ndarray, joint: str, fingers: Sequence[str]) -> None:
    if len(opening) < 4 or np.ptp(opening) < _MIN_TRAVEL:
        raise RobotError(
            f"joint '{joint}' does not open and close {' and '.join(fingers)}: over its "
            f"range, they move by {1e3 * np.ptp(opening):.1f} mm where the tool is"
        )


def _slide(
    model: mujoco.MjModel, joint: int, q: np.ndarray, s: np.ndarray
) -> tuple[float, float] | None:
    """Return offset and sign of a slide that moves its finger straight; None for other joints."""
    sign = float(np.sign(s[-1] - s[0]) * np.sign(q[-1] - q[0]))
    offset = s - sign * q
    if int(model.jnt_type[joint]) != _SLIDE or np.ptp(offset) > _SYMMETRIC:
        return None
    mean = float(offset.mean())
    return (mean if abs(mean) > _SYMMETRIC else 0.0, sign)


def _spring_work(bench: FingerBench, sweep: Sweep, rows: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Fit the effort at a joint that balances the springs, by the principle of virtual work."""
    model = bench.model
    at_q, at_v = model.jnt_qposadr[bench.joints], model.jnt_dofadr[bench.joints]
    rates = np.gradient(sweep.qpos[rows][:, at_q], q, axis=0)
    effort = -(sweep.spring[rows][:, at_v] * rates).sum(axis=1)
    largest = float(np.abs(effort).max())
    if largest <= _NO_EFFORT:
        return np.zeros(1)
    return _polynomial(q, effort, _ACCURATE_EFFORT * largest)


def _fit(q: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Fit a polynomial to the travel s(q) of a finger [m]."""
    coefficients = _polynomial(q, s, _ACCURATE)
    residual = float(np.abs(np.polynomial.polynomial.polyval(q, coefficients) - s).max())
    if residual > _RESIDUAL:
        raise RobotError(
            f"the travel of a finger is no smooth function of its joint: it differs by "
            f"{1e3 * residual:.2f} mm from a polynomial of degree {_DEGREES[-1]}"
        )
    return coefficients


def _polynomial(x: np.ndarray, y: np.ndarray, accuracy: float) -> np.ndarray:
    """Return the coefficients of the simplest accurate polynomial, the constant first."""
    for degree in _DEGREES:
        polynomial = Polynomial.fit(x, y, min(degree, len(x) - 1)).convert()
        if np.abs(polynomial(x) - y).max() < accuracy:
            break
    return polynomial.coef
