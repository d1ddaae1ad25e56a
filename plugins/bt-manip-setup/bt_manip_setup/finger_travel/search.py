"""Search for the two fingers of a gripper in a compiled model."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import literal_name
from bt_manip.grippers import BodySurface, FingerTravel, collision_geoms_of
from bt_manip.robots import RobotError, effort_limit

from .bench import BEHIND, STOPS, FingerBench, ancestors, body_poses, naming
from .measurement import FingerNames, measure_travel

_OPENS = 2e-3  # [m] minimum change of distance of surfaces that open and close
_MEETS = 2e-3  # [m] above the smallest distance, up to which closed surfaces are pads
_UNEVEN = 6e-3  # [m] maximum variation of the distance along the pads
_WIDE = 0.5  # minimum opening of pads, relative to the largest opening
_APART = 5e-4  # [m] distance up to which pads count as closed
_MAX_GEOM_DISTANCE = 1.0  # [m] largest measured distance
_ALIGNED = 0.94  # cosine of 20 degrees: nearer directions are snapped to the base's axes
_DIGITS = 4  # of the tool's position [m]
_MOST_PULLED = 2  # largest number of actuators on spatial tendons, for two fingers
_STEP = 1e-3  # [m] between heights along the fingers
_TIP_DISTANCE = 0.015  # [m] largest distance of the tool from the ends of the pads

_AS_HULL = (
    "a mesh collides as its convex hull; pip install 'bt-manip[convex]' decomposes a concave one, "
    "or give it as several convex ones in the model"
)


class OverlappingHullsError(RobotError):
    """The convex hulls of concave meshes hide how the fingers open and close."""


@dataclass(frozen=True, eq=False)
class FoundFingers:
    """Two fingers of a model, and their dimensions; all names are full names.

    Attributes:
        joints: Joints that the fingers follow: one for each, or one for both.
        fingers: Finger bodies, in the order of the joints; the second may be fixed.
        motor: Joint or tendon moved by the motor for both fingers; None for a motor each.
        max_force: Force that the model's actuators exert with each finger at any opening, less 20 %
            for friction [N]; None if the model does not limit it.
        body: Body that carries the gripper.
        T_bt: Pose of the tool in this body: between the pads where they meet, 15 mm from their ends
            or at half their length; z is the approach direction, y points to the first finger.
        travel: Openings, joint positions, masses and directions, measured at this tool frame.
    """

    joints: tuple[str, ...]
    fingers: tuple[str, str]
    motor: str | None
    max_force: float | None
    body: str
    T_bt: pin.SE3
    travel: FingerTravel


def find_fingers(
    mj_model: mujoco.MjModel,
    arm_joints: Sequence[str],
    *,
    tool: tuple[str, pin.SE3] | None = None,
    where: str = "the model",
) -> FoundFingers:
    """Identify the two fingers of a gripper and measure their travel.

    The gripper's joints are those beyond the arm's last joint. They are moved over their range
    without load, with springs, equality constraints, tendons and closed loops. The fingers are the
    two bodies whose surfaces come nearest to each other; if only one moves, the other is the arm's
    last link or a body fixed to it. Their pads are the surfaces that are far apart when open and
    meet when closed. The closing direction is normal to the pads, and the approach direction points
    from the body that carries the gripper to the pads; both are snapped to axes of this body within
    20 degrees.

    Args:
        mj_model: The robot, compiled on its own; it is not changed.
        arm_joints: Full names of the arm's joints, from the base to the tool.
        tool: Tool frame to use instead: the full name of its body, which is fixed to the body that
            carries the gripper, and its pose in this body. If its z axis is not the approach
            direction of the fingers, its rotation is replaced by theirs.
        where: Name of the robot, for messages.

    Raises:
        RobotError: If there are no two fingers, or they need more than two motors; an
            ``OverlappingHullsError`` where hulls of meshes overlap at every opening.
    """
    bench = FingerBench(mj_model, arm_joints)
    with naming(where):
        joints = _independent_joints(bench)
        sequences = _sequences(bench, joints)
        try:
            return _measured_fingers(bench, joints, sequences, tool)
        except RobotError as error:
            overlap = _overlapping(bench, sequences)
            if not overlap:
                raise
            hidden = isinstance(error, OverlappingHullsError)
            text = "the fingers' opening is hidden" if hidden else error
            raise OverlappingHullsError(f"{text}{overlap}") from None


def _measured_fingers(
    bench: FingerBench,
    joints: list[int],
    sequences: Sequence[np.ndarray],
    tool: tuple[str, pin.SE3] | None,
) -> FoundFingers:
    """Measure the fingers that some joints move."""
    model = bench.model
    pads = _find_pads(bench, sequences)
    if len(joints) == 2 and not bench.coupled(joints[0]) & bench.chain(pads.bodies[0]):
        joints.reverse()
    motor = bench.motor_of(joints)
    first, second = (model.body(body).name for body in pads.bodies)
    names = FingerNames(
        tuple(model.joint(j).name for j in joints), (first, second), motor and motor[1]
    )
    body = _carrier(bench, pads.bodies[0])
    T_bt = _tool(bench, pads, body)
    if tool is not None:
        T_bt = _given_tool(bench, body, T_bt, tool)
    tool_body = model.body(body).name
    travel = measure_travel(bench, names, tool_body=tool_body, T_bt=T_bt)
    geoms = [geom for body in pads.bodies for geom in collision_geoms_of(model, body)]
    has_mesh = int(mujoco.mjtGeom.mjGEOM_MESH) in model.geom_type[geoms]
    if travel.open_width < 0.0 and tool is None and has_mesh:
        raise OverlappingHullsError(
            f"the collision geometries of '{literal_name(first)}' and "
            f"'{literal_name(second)}' overlap by {-1e3 * travel.open_width:.1f} mm where they are "
            f"open: {_AS_HULL}"
        )
    if travel.open_width < _OPENS:
        raise RobotError(
            f"the tool frame is not between the fingers: they open to "
            f"{1e3 * travel.open_width:.0f} mm there (--tool-frame)"
        )
    moved = [("joint", name) for name in names.joints] if motor is None else [motor]
    effort = min(effort_limit(model, getattr(model, kind)(name).id, kind) for kind, name in moved)
    return FoundFingers(
        names.joints,
        names.fingers,
        names.motor,
        _force(travel, names.joints, effort) if np.isfinite(effort) else None,
        tool_body,
        T_bt,
        travel,
    )


def _force(travel: FingerTravel, joints: tuple[str, ...], effort: float) -> float:
    """Return the force of each finger that a motor effort ensures at all openings [N]."""
    zero = travel.efforts(0.0, joints)[0]
    one = travel.efforts(1.0, joints)
    return max(effort - zero, 0.0) / (max(one) - zero)


class _Pads(NamedTuple):
    """Pads of two fingers.

    Attributes:
        bodies: The bodies of the first and the second finger.
        qpos: Positions of the joints when the pads meet.  # (nq,)
        centre: Centre of the pads in the world at these positions [m].  # (3,)
        normal: Direction from the second to the first finger in the world; unit.  # (3,)
    """

    bodies: tuple[int, int]
    qpos: np.ndarray
    centre: np.ndarray
    normal: np.ndarray


def _independent_joints(bench: FingerBench) -> list[int]:
    """Return one joint of each actuated group of coupled joints."""
    model, left, last = bench.model, list(bench.joints), bench.arm_joints[-1]
    if not left:
        raise RobotError(f"there are no joints beyond the arm's last one, '{last}'")
    groups = []
    while left:
        groups.append(bench.coupled(left[0]))
        left = [j for j in left if j not in groups[-1]]
    driven = {j: k for k in reversed(range(model.nu)) for j in bench.moved_by(k)}
    if driven:
        groups = [group for group in groups if group & driven.keys()]
    found = [min(group, key=lambda j: (driven.get(j, model.nu), j)) for group in groups]
    limited = [j for j in found if model.jnt_limited[j]]
    found = _opening_joints(bench, limited) if len(limited) > 2 else limited or found
    names = ", ".join(f"'{literal_name(model.joint(j).name)}'" for j in found)
    pulled = bench.pulling_actuators()
    if len(pulled) > _MOST_PULLED:
        raise RobotError(
            f"{len(pulled)} actuators pull on tendons beyond '{last}'; a two-finger "
            f"gripper has at most {_MOST_PULLED}"
        )
    if len(found) > 2:
        raise RobotError(
            f"{len(found)} joints beyond '{last}' move independently: {names}; "
            "a two-finger gripper has one or two"
        )
    if not limited:
        raise RobotError(
            f"gripper joints without a range: {names}; give them one in the model "
            "(MJCF: range, URDF: <limit>)"
        )
    return found


def _opening_joints(bench: FingerBench, joints: Sequence[int]) -> list[int]:
    """Return the joints that move surfaces towards others; others only decorate the gripper."""
    model, opened = bench.model, []
    for joint in joints:
        moved = {b for b in bench.bodies if bench.chain(b) & bench.coupled(joint)}
        geoms = _geom_pairs(model, product(moved, set(bench.bodies) - moved))
        qpos = bench.sweep(joint, [j for j in joints if j != joint]).qpos
        distances = _distances(model, qpos, geoms)
        opened.append(float(np.ptp(distances, axis=0).max()) if geoms else 0.0)
    return [j for j, change in zip(joints, opened, strict=True) if change > _WIDE * max(opened)]


def _sequences(bench: FingerBench, joints: Sequence[int]) -> list[np.ndarray]:
    """Return the positions of all joints over the range: both fingers parallel and opposed."""
    sweeps = [bench.sweep(joint, [j for j in joints if j != joint]).qpos for joint in joints]
    if len(sweeps) == 1:
        return sweeps
    rows = np.linspace(0, [len(sweep) - 1 for sweep in sweeps], STOPS).round().astype(int)
    first, second = sweeps[0][rows[:, 0]], sweeps[1][rows[:, 1]]
    at = bench.model.jnt_qposadr[sorted(bench.coupled(joints[1]))]
    found = [first.copy(), first.copy()]
    found[0][:, at], found[1][:, at] = second[:, at], second[::-1, at]
    return found


def _find_pads(bench: FingerBench, sequences: Sequence[np.ndarray]) -> _Pads:
    """Find the surfaces that are far apart when open and meet when closed."""
    model = bench.model
    moving = [b for b in bench.bodies if bench.chain(b)]
    fixed = [b for b in bench.bodies if b not in moving]
    for pairs in (combinations(moving, 2), product(moving, fixed)):
        geoms = _geom_pairs(model, pairs)
        if not geoms:
            continue
        measured = [(sequence, _distances(model, sequence, geoms)) for sequence in sequences]
        sequence, distances = max(measured, key=lambda one: _opening(one[1]).max())
        if _opening(distances).max() > _OPENS:
            return _pads_of(bench, sequence, distances, geoms)
    bare = [b for b in bench.bodies if not collision_geoms_of(model, b)]
    names = ", ".join(repr(literal_name(model.body(b).name)) for b in bare)
    lacking = f"; give a collision geometry to the bodies without one: {names}" if bare else ""
    raise RobotError(
        f"no two surfaces beyond the arm's last joint open and close by more than "
        f"{1e3 * _OPENS:.0f} mm{lacking}"
    )


def _overlapping(bench: FingerBench, sequences: Sequence[np.ndarray]) -> str:
    """Explain that a mesh overlaps another body at every opening; empty if none does."""
    model, mesh = bench.model, int(mujoco.mjtGeom.mjGEOM_MESH)
    moved = [(a, b) for a, b in combinations(bench.bodies, 2) if bench.chain(a) != bench.chain(b)]
    geoms = [pair for pair in _geom_pairs(model, moved) if mesh in model.geom_type[list(pair)]]
    for sequence in sequences if geoms else ():
        for pair in np.flatnonzero((_distances(model, sequence, geoms) <= 0.0).all(axis=0)):
            first, second = (
                f"'{literal_name(model.body(model.geom_bodyid[geom]).name)}'"
                for geom in geoms[pair]
            )
            return (
                f"; the collision geometries of {first} and {second} overlap at every opening: "
                f"{_AS_HULL}"
            )
    return ""


def _geom_pairs(model: mujoco.MjModel, bodies: Iterable[tuple[int, int]]) -> list[tuple[int, int]]:
    return [
        pair
        for a, b in bodies
        for pair in product(collision_geoms_of(model, a), collision_geoms_of(model, b))
    ]


def _distances(
    model: mujoco.MjModel, sequence: np.ndarray, geoms: Sequence[tuple[int, int]]
) -> np.ndarray:
    """Return the distances of pairs of geoms at positions of all joints [m]."""  # (m, len(geoms))
    rows = [
        [mujoco.mj_geomDistance(model, data, *pair, _MAX_GEOM_DISTANCE, None) for pair in geoms]
        for data in (_posed(model, qpos) for qpos in sequence)
    ]
    return np.array(rows)


def _opening(distances: np.ndarray) -> np.ndarray:
    return np.abs(distances[-1] - distances[0])


def _posed(model: mujoco.MjModel, qpos: np.ndarray) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    return data


def _pads_of(
    bench: FingerBench,
    sequence: np.ndarray,
    distances: np.ndarray,
    geoms: Sequence[tuple[int, int]],
) -> _Pads:
    """Return the pads among pairs of geoms, by their distances at positions of all joints."""
    model, opens = bench.model, _opening(distances)
    wide = opens > _WIDE * opens.max()
    bodies = model.geom_bodyid[np.array(geoms)]
    gaps = distances[:, wide].min(axis=1)
    if gaps[0] < gaps[-1]:  # from open to closed
        sequence, distances = sequence[::-1], distances[::-1]
    nearest = _first_to_meet(bench, np.where(wide, distances, np.inf), bodies)
    wide = np.flatnonzero(wide & (bodies == bodies[nearest]).all(axis=1))
    gaps = distances[:, wide].min(axis=1)
    row = int(np.abs(gaps).argmin())
    meeting = wide[distances[row, wide] < gaps[row] + _MEETS]
    before = max(np.flatnonzero(gaps > _APART), default=0)
    pair = geoms[int(meeting[distances[before, meeting].argmin()])]
    ends = np.zeros(6)
    mujoco.mj_geomDistance(model, _posed(model, sequence[before]), *pair, _MAX_GEOM_DISTANCE, ends)
    normal = ends[:3] - ends[3:]
    pads = np.unique(np.array(geoms)[meeting])
    return _Pads(
        (int(bodies[nearest, 0]), int(bodies[nearest, 1])),
        sequence[row],
        _posed(model, sequence[row]).geom_xpos[pads].mean(axis=0),
        normal / np.linalg.norm(normal),
    )


def _first_to_meet(bench: FingerBench, distances: np.ndarray, bodies: np.ndarray) -> int:
    """Return the pair of geoms that close on an object: the first to meet, of the same kind.

    Bodies of one kind are as deep in the tree, on as many joints, with as many geoms: two pads, not
    a pad and the link that carries the other one. The distances are from open to closed, inf for
    pairs that are no pads.
    """

    def kind(body: int) -> tuple[int, int, int]:
        geoms = collision_geoms_of(bench.model, body)
        return len(ancestors(bench.model, body)), len(bench.chain(body)), len(geoms)

    row = max(np.flatnonzero(distances.min(axis=1) > _APART), default=0)
    near = np.flatnonzero(distances[row] < distances[row].min() + _MEETS)
    alike = [kind(int(a)) == kind(int(b)) for a, b in bodies[near]]
    return int(near[np.lexsort((distances[row, near], np.logical_not(alike)))[0]])


def _carrier(bench: FingerBench, finger: int) -> int:
    """Return the body that carries the mechanism of a finger."""
    first = min(int(bench.model.jnt_bodyid[j]) for j in bench.chain(finger))
    return int(bench.model.body_parentid[first])


def _tool(bench: FingerBench, pads: _Pads, body: int) -> pin.SE3:
    """Return the pose of the tool between the pads, in the frame of the gripper's base."""
    T_wb = body_poses(_posed(bench.model, pads.qpos))
    T_bw = T_wb[body].inverse()
    y = _aligned(T_bw.rotation @ pads.normal)
    centre = T_bw.act(pads.centre)
    z = _aligned(centre - (centre @ y) * y)
    z -= (z @ y) * y
    z /= np.linalg.norm(z)
    T_bt = pin.SE3(np.column_stack([np.cross(y, z), y, z]), centre)
    surfaces = [BodySurface(bench.model, b) for b in pads.bodies]
    poses = [(T_wb[body] * T_bt).inverse() * T_wb[b] for b in pads.bodies]

    def corners(height: float) -> list[np.ndarray]:
        return [_section(s, T, height) for s, T in zip(surfaces, poses, strict=True)]

    def gap(height: float) -> float:
        first, second = corners(height)
        if not len(first) or not len(second):
            return np.inf
        return float(first[:, 1].min() - second[:, 1].max())

    reference = gap(0.0)
    ends = []
    for step in (-_STEP, _STEP):
        height = 0.0
        while abs(gap(height + step) - reference) < _UNEVEN:
            height += step
        ends.append(height - np.sign(step) * BEHIND)
    height = max(0.5 * (ends[0] + ends[1]), ends[1] - _TIP_DISTANCE)
    first, second = corners(height)
    both = np.concatenate([first, second])
    at = np.array([
        0.5 * (both[:, 0].min() + both[:, 0].max()),
        0.5 * (first[:, 1].min() + second[:, 1].max()),
        height,
    ])  # fmt: skip
    return pin.SE3(T_bt.rotation, np.round(T_bt.act(at), _DIGITS) + 0.0)


def _section(surface: BodySurface, T_tb: pin.SE3, height: float) -> np.ndarray:
    """Return a surface's corners within `BEHIND` of a plane z = height [m]."""  # (n, 3)
    part, rest = (surface.beyond(T_tb, height + d) for d in (-BEHIND, BEHIND))
    cut = rest[:, 2] < height + BEHIND + 1e-9
    return np.concatenate([part[part[:, 2] <= height + BEHIND], rest[cut]])


def _given_tool(bench: FingerBench, body: int, T_bt: pin.SE3, tool: tuple[str, pin.SE3]) -> pin.SE3:
    """Return the pose of a given tool frame in the frame of the gripper's base."""
    model, (name, T) = bench.model, tool
    own = int(model.body(name).id)
    if model.body_weldid[own] != model.body_weldid[body]:
        carrier = literal_name(model.body(body).name)
        raise RobotError(
            f"the tool frame moves with '{literal_name(name)}'; it has to be fixed to the "
            f"body that carries the fingers, '{carrier}'"
        )
    T_wb = body_poses(_posed(model, model.qpos0))
    given = T_wb[body].inverse() * T_wb[own] * T
    aligned = given.rotation[:, 2] @ T_bt.rotation[:, 2] > _ALIGNED
    return given if aligned else pin.SE3(T_bt.rotation, given.translation)


def _aligned(direction: np.ndarray) -> np.ndarray:
    """Return the coordinate axis within 20 degrees of a direction, or else the unit direction."""
    unit = direction / np.linalg.norm(direction)
    k = int(np.abs(unit).argmax())
    return np.sign(unit[k]) * np.eye(3)[k] if abs(unit[k]) > _ALIGNED else unit
