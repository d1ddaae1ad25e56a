"""Travel of the fingers of a gripper as a function of its joints."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotError

from .finger_bench import BEHIND, STOPS, FingerBench, FingerSurface, Settled, relative_motion

_TENDON = int(mujoco.mjtObj.mjOBJ_TENDON)
_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)

_DEGREES = (1, 5, 7)  # of the fitted polynomials: the first that is accurate
_ACCURATE = 2e-5  # [m] error of the fitted travel
_RESIDUAL = 1e-3  # [m] the same, at most
_SYMMETRIC = 3e-4  # [m] offset of a slide from its distance from the centre that is neglected
_DIGITS = 9  # of the closing direction
_CENTRED = 1e-3  # [m] maximum distance of the pads' centre from the tool, up to which it is zero
_MIN_TRAVEL = 1e-3  # [m] of the opening
_MOVES = 1e-6  # [m] or [rad] motion of a joint above which it moves with the fingers
_FIXED = 0.1  # share of the opening's travel up to which a finger is fixed
_ACCURATE_EFFORT = 0.01  # share of the largest effort against springs
_NO_EFFORT = 1e-4  # [N] or [N m] up to which springs are negligible
_MARGIN = 1.2  # of the motors' efforts, for friction


@dataclass(frozen=True, eq=False)
class FingerTravel:
    """Travel of two fingers as a function of their joints.

    The opening is the distance between the fingers along their relative motion, from the tool
    centre point to the tips along the approach direction. Each finger has a distance s from the
    centre; the opening is the sum of both. Fingers of one motor have half the opening each, also if
    only one of them moves. By the principle of virtual work, a force of 1 N at the finger requires
    an effort of ds/dq at the joint.

    Attributes:
        open_width: Maximum opening [m].
        min_width: Minimum opening [m].
        polynomials: Coefficients of s(q) for each finger, the constant first.
        holding: Coefficients of each motor's effort against springs as a function of q.
        ratios: Velocity of each finger's joint per velocity of the motor.  # (2,)
        mass: Effective mass of one finger along s [kg]; 0 to read it from the joint.
        loss: Viscous friction of one finger, along s [N s/m].
        friction: Dry friction of one finger, along s [N].
        joints: Names of all joints that move with the fingers.
        widths: Openings at which `positions` were measured, increasing [m].  # (m,)
        positions: Positions of the joints at `widths`.  # (m, len(joints))
        columns: Indices of the joints of the two fingers in `joints`.
        closing: Direction from the second to the first finger in the tool frame; unit.  # (3,)
        centre: Coordinate along `closing` of the midpoint between the fingers in the tool frame, at
            zero opening [m], and its change per opening: 0.5 if the second finger is fixed.
    """

    open_width: float
    min_width: float
    polynomials: tuple[np.ndarray, np.ndarray]
    holding: tuple[np.ndarray, np.ndarray]
    ratios: np.ndarray
    mass: float
    loss: float
    friction: float
    joints: tuple[str, ...]
    widths: np.ndarray
    positions: np.ndarray
    columns: tuple[int, int]
    closing: np.ndarray
    centre: tuple[float, float]

    @property
    def one_moves(self) -> bool:
        """Whether the second finger is fixed."""
        return self.centre[1] != 0.0

    def configuration(self, width: float) -> np.ndarray:
        """Return the positions of all moving joints at an opening [m]."""  # (len(joints),)
        return np.array([np.interp(width, self.widths, column) for column in self.positions.T])

    def efforts(self, force: float, *, together: bool) -> list[float]:
        """Return the maximum effort of each motor for a force of each finger.

        It includes a margin of 20 % for friction.

        Args:
            force: Force of each finger [N].
            together: Whether one motor moves both.
        """
        efforts = [_MARGIN * force * steepest for steepest in self._steepest()]
        springs = [
            float(np.abs(np.polynomial.Polynomial(p)(self.positions[:, c])).max())
            for p, c in zip(self.holding, self.columns, strict=True)
        ]
        if together:
            return [sum(efforts) + springs[0]]
        return [effort + spring for effort, spring in zip(efforts, springs, strict=True)]

    def force(self, effort: float, *, together: bool) -> float:
        """Return the force of each finger that motors of an effort exert everywhere [N]."""
        zero = self.efforts(0.0, together=together)[0]
        one = self.efforts(1.0, together=together)
        return max(effort - zero, 0.0) / (max(one) - zero)

    def _steepest(self) -> list[float]:
        """Return each motor's maximum effort for a force of 1 N of its finger."""
        found = []
        for polynomial, ratio, column in zip(
            self.polynomials, self.ratios, self.columns, strict=True
        ):
            slope = np.polynomial.Polynomial(polynomial).deriv()
            found.append(float(np.abs(slope(self.positions[:, column]) * ratio).max()))
        return found


class FingerNames(NamedTuple):
    """Full names of a gripper's parts in the compiled model.

    Attributes:
        joints: The joints that the fingers follow: one for each, or one for both.
        fingers: The finger bodies.
        motor: The joint or tendon moved by the only motor; None for a motor for each joint.
    """

    joints: tuple[str, ...]
    fingers: tuple[str, str]
    motor: str | None


class _Course(NamedTuple):
    """Positions of a mechanism from closed to open.

    Attributes:
        qpos: Positions of all joints.  # (m, nq)
        spring: Spring efforts.  # (m, nv)
        lengths: Position of the motor's joint or tendon.  # (m,)
        faces: Coordinates of the inner faces of both fingers, or of the one that moves, along the
            closing direction [m].  # (m, 2) or (m, 1)
    """

    qpos: np.ndarray
    spring: np.ndarray
    lengths: np.ndarray
    faces: np.ndarray


def measure_travel(
    bench: FingerBench, names: FingerNames, *, tool_body: str, T_bt: pin.SE3, where: str
) -> FingerTravel:
    """Measure the travel of two fingers by moving the gripper over its range without load.

    Args:
        bench: The robot, compiled on its own.
        names: The gripper's joints, fingers and motor.
        tool_body: Full name of the body that carries the tool.
        T_bt: Pose of the tool in that body; its z axis is the approach direction.
        where: Name of the robot, for messages.

    Raises:
        RobotError: If the joints have no range, do not move the fingers, or move them so that one
            opening has several positions.
    """
    model = bench.model
    joints = [int(model.joint(name).id) for name in names.joints]
    unlimited = [n for n, j in zip(names.joints, joints, strict=True) if not model.jnt_limited[j]]
    if unlimited:
        raise RobotError(f"{where}: gripper joints without a range: {', '.join(unlimited)}")
    outside = [n for n, j in zip(names.joints, joints, strict=True) if j not in bench.joints]
    if outside:
        raise RobotError(
            f"{where}: {', '.join(outside)} is no gripper joint: it does not move beyond the arm's "
            f"last joint, '{bench.arm_joints[-1]}'"
        )
    surfaces = [FingerSurface(model, int(model.body(name).id)) for name in names.fingers]
    tool = int(model.body(tool_body).id)
    if names.motor is None and len(joints) == 2:
        sweeps = [bench.sweep(joints[0], joints[1:]), bench.sweep(joints[1], joints[:1])]
    else:
        sweeps = [bench.sweep(joints[0])] * 2
    # Of each finger, in the tool frame: (stops, points), from the sweep that moves it.
    poses = [
        [(stop.bodies[tool] * T_bt).inverse() * stop.bodies[surface.body] for stop in sweep]
        for surface, sweep in zip(surfaces, sweeps, strict=True)
    ]
    sections = [
        [surface.beyond(T, -BEHIND) for T in column]
        for surface, column in zip(surfaces, poses, strict=True)
    ]
    for name, surface, column, crossing in zip(
        names.fingers, surfaces, poses, sections, strict=True
    ):
        if not any(len(points) for points in crossing):
            raise RobotError(_beside(surface, name, column, where))
    closing = _closing(poses, sections)
    first, second = (
        np.array([(side * (points @ closing)).min(initial=np.inf) for points in column])
        for side, column in zip((1.0, -1.0), sections, strict=True)
    )
    first[np.isinf(first)] = second[np.isinf(second)] = np.nan
    motor = _Motor(model, names.motor)
    if sweeps[0] is sweeps[1]:
        faces = np.column_stack([first, -second])
        course = _course(sweeps[0], faces, first + second, motor)
        return _coupled(bench, course, joints, names, closing, where)
    courses = [
        _course(sweep, sign * face[:, None], face, motor)
        for sweep, sign, face in zip(sweeps, (1.0, -1.0), (first, second), strict=True)
    ]
    return _independent(bench, courses, joints, names, closing, where)


class _Motor:
    """Position of the joint, or length of the tendon, that a motor moves."""

    def __init__(self, model: mujoco.MjModel, name: str | None) -> None:
        self._tendon = self._qpos = -1
        if name is not None:
            self._tendon = mujoco.mj_name2id(model, _TENDON, name)
            if self._tendon < 0:
                self._qpos = int(model.jnt_qposadr[model.joint(name).id])

    def length(self, stop: Settled) -> float:
        if self._tendon >= 0:
            return float(stop.tendons[self._tendon])
        return float(stop.qpos[self._qpos]) if self._qpos >= 0 else 0.0


def _beside(surface: FingerSurface, name: str, poses: Sequence[pin.SE3], where: str) -> str:
    heights = np.concatenate([surface.beyond(T, -np.inf) for T in poses])[:, 2]
    if not len(heights):
        return f"{where}: finger '{name}' has no geom that collides"
    ahead = heights.max() < 0.0
    distance = -heights.max() if ahead else heights.min()
    return (
        f"{where}: the tool frame is not between the fingers: along its z axis, '{name}' is "
        f"{1e3 * distance:.1f} mm {'behind' if ahead else 'beyond'} it"
    )


def _closing(
    poses: Sequence[Sequence[pin.SE3]], sections: Sequence[Sequence[np.ndarray]]
) -> np.ndarray:
    """Return the direction from the second to the first finger, along their relative motion."""
    first, second = (relative_motion(column, np.zeros(3))[:2] for column in poses)
    axis = first + np.sign(first @ second) * second
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        return np.array([1.0, 0.0, 0.0])
    centres = [np.concatenate(column).mean(axis=0)[:2] for column in sections]
    sign = 1.0 if axis @ (centres[0] - centres[1]) > 0.0 else -1.0
    return np.array([*np.round(sign * axis / length, _DIGITS), 0.0]) + 0.0


def _course(
    sweep: Sequence[Settled], faces: np.ndarray, travel: np.ndarray, motor: _Motor
) -> _Course:
    """Return the longest part of a sweep in which the travel changes monotonically, from closed."""
    best = (0, 1)
    steps = np.diff(travel)
    for sign in (1.0, -1.0):
        start = 0
        for i, step in enumerate(np.append(steps, np.nan)):
            if not sign * step > 0.0:
                if i - start >= best[1] - best[0]:
                    best = (start, i + 1)
                start = i + 1
    rows = list(range(*best))
    if travel[rows[-1]] < travel[rows[0]]:
        rows = rows[::-1]
    return _Course(
        np.array([sweep[i].qpos for i in rows]),
        np.array([sweep[i].spring for i in rows]),
        np.array([motor.length(sweep[i]) for i in rows]),
        faces[rows],
    )


def _coupled(
    bench: FingerBench,
    course: _Course,
    joints: list[int],
    names: FingerNames,
    closing: np.ndarray,
    where: str,
) -> FingerTravel:
    """Return the travel of fingers that one motor moves."""
    model = bench.model
    opening = course.faces[:, 0] - course.faces[:, 1]
    _check_opening(opening, names, where)
    own = [joints[0], joints[-1]]
    q = course.qpos[:, model.jnt_qposadr[own]]
    if np.ptp(q[:, 1]) < 1e-6:
        raise RobotError(
            f"{where}: one motor moves both fingers, but nothing in the model couples joint "
            f"'{names.joints[1]}' to '{names.joints[0]}'; an equality does, or leave out 'motor'"
        )
    s = 0.5 * opening
    ratios = np.ones(2)
    if np.ptp(course.lengths) > 0.0:
        ratios = np.array([np.polyfit(course.lengths, column, 1)[0] for column in q.T])
    work = _spring_work(bench, course, q[:, 0]) * ratios[0]
    fixed = np.ptp(course.faces[:, 1]) < _FIXED * np.ptp(opening)
    slope = 0.5 if fixed else 0.0
    offset = float((course.faces.mean(axis=1) - slope * opening).mean())
    return _travel(
        bench,
        opening,
        course.qpos,
        own,
        (_fit(q[:, 0], s, where), _fit(q[:, 1], s, where)),
        (work, np.zeros(1)),
        ratios,
        closing,
        (offset if fixed or abs(offset) > _CENTRED else 0.0, slope),
    )


def _independent(
    bench: FingerBench,
    courses: Sequence[_Course],
    joints: list[int],
    names: FingerNames,
    closing: np.ndarray,
    where: str,
) -> FingerTravel:
    """Return the travel of fingers with a motor each."""
    model = bench.model
    first, second = (course.faces[:, 0] for course in courses)
    for face, i in ((first, 0), (-second, 1)):
        _check_opening(face, names, where, i)
    centre = 0.5 * float(first[0] + second[0])
    s = [first - centre, centre - second]
    qs = [c.qpos[:, model.jnt_qposadr[j]] for c, j in zip(courses, joints, strict=True)]
    holding = [_spring_work(bench, c, q) for c, q in zip(courses, qs, strict=True)]
    slides = [_slide(model, j, q, t) for j, q, t in zip(joints, qs, s, strict=True)]
    direct = None not in slides and not any(work.any() for work in holding)
    if direct:
        polynomials = [np.array(slide) for slide in slides]
        ends = np.sort(
            [p[0] + p[1] * model.jnt_range[j] for p, j in zip(polynomials, joints, strict=True)]
        )
        grid = np.array([ends[:, 0].max(), ends[:, 1].min()])
        columns = [(grid - p[0]) / p[1] for p in polynomials]
    else:
        polynomials = [_fit(q, t, where) for q, t in zip(qs, s, strict=True)]
        grid = np.linspace(max(t[0] for t in s), min(t[-1] for t in s), STOPS)
    qpos = np.repeat(courses[0].qpos[:1], len(grid), axis=0)
    for course, t, joint in zip(courses, s, joints, strict=True):
        for moved in bench.coupled(joint):
            column = model.jnt_qposadr[moved]
            qpos[:, column] = np.interp(grid, t, course.qpos[:, column])
    if direct:
        qpos[:, model.jnt_qposadr[joints]] = np.transpose(columns)
    travel = _travel(
        bench,
        2.0 * grid,
        qpos,
        joints,
        (polynomials[0], polynomials[1]),
        (holding[0], holding[1]),
        np.ones(2),
        closing,
        (centre if abs(centre) > _CENTRED else 0.0, 0.0),
    )
    return replace(travel, mass=0.0) if direct else travel


def _travel(
    bench: FingerBench,
    widths: np.ndarray,
    qpos: np.ndarray,
    own: Sequence[int],
    polynomials: tuple[np.ndarray, np.ndarray],
    holding: tuple[np.ndarray, np.ndarray],
    ratios: np.ndarray,
    closing: np.ndarray,
    centre: tuple[float, float],
) -> FingerTravel:
    """Return the travel with its mass and friction, half way."""
    model = bench.model
    moving = [j for j in bench.joints if np.ptp(qpos[:, model.jnt_qposadr[j]]) > _MOVES]
    at_q, at_v = model.jnt_qposadr[moving], model.jnt_dofadr[moving]
    middle = len(widths) // 2
    before, after = max(middle - 1, 0), min(middle + 1, len(widths) - 1)
    q = qpos[:, at_q]
    dq = (q[after] - q[before]) / (0.5 * (widths[after] - widths[before]))
    data = mujoco.MjData(model)
    data.qpos[:] = qpos[middle]
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return FingerTravel(
        open_width=float(widths[-1]),
        min_width=max(float(widths[0]), 0.0),
        polynomials=polynomials,
        holding=holding,
        ratios=ratios,
        mass=0.5 * float(dq @ full[np.ix_(at_v, at_v)] @ dq),
        loss=0.5 * float(dq @ (model.dof_damping[at_v] * dq)),
        friction=0.5 * float(bench.frictionloss[at_v] @ np.abs(dq)),
        joints=tuple(model.joint(j).name for j in moving),
        widths=widths,
        positions=q,
        columns=(moving.index(own[0]), moving.index(own[1])),
        closing=closing,
        centre=centre,
    )


def _check_opening(
    opening: np.ndarray, names: FingerNames, where: str, finger: int | None = None
) -> None:
    if len(opening) < 4 or np.ptp(opening) < _MIN_TRAVEL:
        joint = names.joints[finger or 0]
        moved = (
            "the fingers " + " and ".join(names.fingers)
            if finger is None
            else (f"finger {names.fingers[finger]}")
        )
        raise RobotError(
            f"{where}: joint '{joint}' does not open and close {moved}: over its range, they move "
            f"by {1e3 * np.ptp(opening):.1f} mm where the tool is"
        )


def _slide(
    model: mujoco.MjModel, joint: int, q: np.ndarray, s: np.ndarray
) -> tuple[float, float] | None:
    """Return offset and sign of a slide that moves its finger straight; None for another joint."""
    sign = float(np.sign(s[-1] - s[0]) * np.sign(q[-1] - q[0]))
    offset = s - sign * q
    if int(model.jnt_type[joint]) != _SLIDE or np.ptp(offset) > _SYMMETRIC:
        return None
    mean = float(offset.mean())
    return (mean if abs(mean) > _SYMMETRIC else 0.0, sign)


def _spring_work(bench: FingerBench, course: _Course, q: np.ndarray) -> np.ndarray:
    """Fit the effort at a joint that balances the springs, by the principle of virtual work."""
    model = bench.model
    at_q, at_v = model.jnt_qposadr[bench.joints], model.jnt_dofadr[bench.joints]
    rates = np.gradient(course.qpos[:, at_q], q, axis=0)
    effort = -(course.spring[:, at_v] * rates).sum(axis=1)
    largest = float(np.abs(effort).max())
    return (
        _polynomial(q, effort, _ACCURATE_EFFORT * largest) if largest > _NO_EFFORT else np.zeros(1)
    )


def _fit(q: np.ndarray, s: np.ndarray, where: str) -> np.ndarray:
    """Fit a polynomial to the travel s(q) of a finger [m]."""
    coefficients = _polynomial(q, s, _ACCURATE)
    residual = float(np.abs(np.polynomial.polynomial.polyval(q, coefficients) - s).max())
    if residual > _RESIDUAL:
        raise RobotError(
            f"{where}: the travel of a finger is no smooth function of its joint: it differs by "
            f"{1e3 * residual:.2f} mm from a polynomial of degree {_DEGREES[-1]}"
        )
    return coefficients


def _polynomial(x: np.ndarray, y: np.ndarray, accuracy: float) -> np.ndarray:
    """Return the coefficients of the simplest polynomial of an accuracy, the constant first."""
    for degree in _DEGREES:
        polynomial = np.polynomial.Polynomial.fit(x, y, min(degree, len(x) - 1)).convert()
        if np.abs(polynomial(x) - y).max() < accuracy:
            break
    return polynomial.coef
