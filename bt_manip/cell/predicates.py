"""Predicates on objects: at rest, released, in a container, on a support.

All predicates are false in a state that is not finite. Whether a container surrounds an object is
decided by rays that hit its collision geometry, not by its bounding box.
"""

import math
from itertools import chain, product
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from .contacts.contact_monitor import MonitoredEntity
from .geometry import collision_geoms, extent
from .naming import entity_of

if TYPE_CHECKING:
    from .cell import Cell

MAX_REST_SPEED = 5e-3  # [m/s] maximum speed of an object at rest
MAX_CORNER_SPEED = 10e-3  # [m/s] of the fastest corner of its bounding box
MIN_TOPPLING_SPEED = 1e-3  # [m/s] of that corner, from which on its acceleration counts
MIN_TOPPLING = 20e-3  # [m/s^2] acceleration of that corner, along its velocity
MAX_REST_TURNING = 0.2  # [rad/s] maximum angular speed: 9 mm/s at a corner of a 50 mm cube
RIM = 5e-3  # [m] contacts less than this below a container's top are on its rim, not inside
MAX_REST_ACCELERATION = 1.0  # [m/s^2] of an object at rest; at a turning point it is larger
AHEAD = 20e-3  # [s] over which the mean motion counts where contacts flutter
_RAYS = 16  # number of directions in which a container must surround a point
_LEVELS = 4  # number of heights of these rays, from `RIM` to the object's height
_FINE = 17  # number of heights, and of places side by side, where all of these rays miss
MIN_SLOPE = 0.05  # [-] minimum vertical component of the normal of a supporting contact
MIN_SUPPORT = 0.25  # [-] minimum share of an object's weight carried by a support
_DOWN = np.array([0.0, 0.0, -1.0])


def at_rest(cell: "Cell", name: str) -> bool:
    """Return whether an object is at rest.

    Raises:
        CellError: If there is no such object.
    """
    return not why_not_at_rest(cell, name)


def is_in(cell: "Cell", name: str, container: str) -> bool:
    """Return whether an object is at rest inside a container.

    The container surrounds the place below the object's centre and a place where it, or an
    object inside, supports the object. The object touches only the container and freely moving
    objects, so a gripped object is not in the container.

    Raises:
        CellError: If there is no such object or container.
    """
    return not why_not_in(cell, name, container)


def is_on(cell: "Cell", name: str, support: str) -> bool:
    """Return whether an object is at rest on another one.

    No robot touches it, and the support carries part of its weight from below.

    Raises:
        CellError: If there is no such object or support.
    """
    return not why_not_on(cell, name, support)


def is_within(cell: "Cell", name: str, container: str) -> bool:
    """Return whether a container surrounds an object's lowest part, moving, held or at rest.

    Raises:
        CellError: If there is no such object or container.
    """
    lower, upper = extent(cell, name)
    centre = 0.5 * (lower + upper)
    return _is_inside(cell, container, np.array([*centre[:2], lower[2]]), upper - lower)


def surrounds(
    cell: "Cell",
    name: str,
    points: np.ndarray,
    axis: np.ndarray | None = None,
    within: float = math.inf,
    width: float = 0.0,
) -> bool:
    """Return whether an entity's collision geometry surrounds a place.

    In each of `_RAYS` directions perpendicular to an axis, a ray from at least one of the points
    must hit it; gaps between these directions go unnoticed.

    Args:
        cell: The cell.
        name: The entity.
        points: Points of the place in the world [m].  # (n, 3)
        axis: The axis in the world; default: vertical.  # (3,)
        within: Maximum distance of the geometry [m].
        width: Width of an object at the place, for which narrower gaps, as of a wire basket, are
            closed: where rays from all points miss, rays beside and between them count [m].

    Raises:
        CellError: If there is no such entity.
    """
    up = np.array([0.0, 0.0, 1.0]) if axis is None else axis
    geoms = collision_geoms(cell, name).tolist()
    first = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    first /= np.linalg.norm(first)
    second = np.cross(up, first)
    heights = np.linspace(points[0], points[-1], _FINE)
    sides = np.linspace(-0.5 * width, 0.5 * width, _FINE)
    for angle in np.arange(_RAYS) * (2.0 * math.pi / _RAYS):
        ray = math.cos(angle) * first + math.sin(angle) * second
        across = np.cross(up, ray)
        beside = (h + side * across for side in sides for h in heights) if width > 0.0 else ()
        distances = (_distance(cell, g, p, ray) for p in chain(points, beside) for g in geoms)
        if not any(0.0 <= distance <= within for distance in distances):
            return False
    return True


def is_rest_velocity(velocity: np.ndarray) -> bool:
    """Return whether a linear and angular velocity is that of an object at rest."""  # (6,)
    return not _why_moving(velocity)


def why_not_at_rest(cell: "Cell", name: str) -> str:
    """Return why an object is not at rest; empty if it is.

    Raises:
        CellError: If there is no such object.
    """
    if (reason := _why_fast(cell, name)) or not cell.is_free(name):
        return reason
    dof = cell.model.body_dofadr[cell.body_id(name)]
    reason = _why_leaving(cell, name, cell.velocity(name), cell.data.qacc[dof : dof + 6])
    if reason and cell.contacts.touching(name):  # contacts of objects at rest may flutter
        reason = _why_leaving(cell, name, *_motion_ahead(cell, name))
    return reason and f"'{name}' {reason}"


def _why_fast(cell: "Cell", name: str) -> str:
    """Return why an object moves too fast for rest; empty if it does not."""
    cell.find(name)
    if not (np.isfinite(cell.data.qpos).all() and np.isfinite(cell.data.qvel).all()):
        return "the state of the cell is not finite"
    reason = _why_moving(cell.velocity(name))
    return reason and f"'{name}' {reason}"


def _motion_ahead(cell: "Cell", name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean motion of a free object over the next `AHEAD`, found on a copy of the state.

    Returns:
        Its linear and angular velocity, in the world [m/s, rad/s].  # (6,)
        Its linear acceleration, in the world [m/s^2], and its angular acceleration, in its own
        frame [rad/s^2]: the change between the mean velocities of two such spans.  # (6,)
    """
    model = cell.model
    dof = model.body_dofadr[cell.body_id(name)]
    steps = max(round(AHEAD / model.opt.timestep), 1)
    trial = mujoco.MjData(model)
    mujoco.mj_copyData(trial, model, cell.data)
    means = np.zeros((2, model.nv))
    for mean in means:
        before = trial.qpos.copy()
        mujoco.mj_step(model, trial, steps)
        mujoco.mj_differentiatePos(model, mean, steps * model.opt.timestep, before, trial.qpos)
    first, second = means[:, dof : dof + 6]
    turning = cell.pose(name).rotation @ first[3:]
    return np.r_[first[:3], turning], (second - first) / (steps * model.opt.timestep)


def _why_leaving(cell: "Cell", name: str, velocity: np.ndarray, acceleration: np.ndarray) -> str:
    """Describe why a free object will not stay as it is; empty if it will; see `_why_topples`."""
    size = float(np.linalg.norm(acceleration[:3]))
    if not size <= MAX_REST_ACCELERATION:
        falls = not cell.contacts.touching(name)
        return "touches nothing" if falls else f"is accelerated by {size:.1f} m/s^2"
    if len(collision_geoms(cell, name)):
        return _why_topples(cell, name, velocity, acceleration)
    return ""


def why_not_released(cell: "Cell", name: str) -> str:
    """Return why an object is not left alone at rest: it moves, or a robot touches it.

    Raises:
        CellError: If there is no such object.
    """
    reason = why_not_at_rest(cell, name)
    robots = (
        f"'{name}' touches '{other}'"
        for other in cell.contacts.partners(name)
        if isinstance(cell.entities.get(entity_of(other)), MonitoredEntity)
    )
    return reason or next(robots, "")


def why_not_in(cell: "Cell", name: str, container: str) -> str:
    """Return why `is_in` does not hold; empty if it does.

    Raises:
        CellError: If there is no such object or container.
    """
    cell.find(container)
    return (
        _why_fast(cell, name)
        or _why_astray(cell, name, container)
        or why_not_at_rest(cell, name)
        or _why_unsupported(cell, name, container, {container})
    )


def why_not_on(cell: "Cell", name: str, support: str) -> str:
    """Return why `is_on` does not hold; empty if it does.

    Raises:
        CellError: If there is no such object or support.
    """
    cell.find(support)
    if reason := why_not_released(cell, name):
        return reason
    points = [p for p in cell.contacts.points(name) if entity_of(p.other) == support]
    if not points:
        return f"'{name}' does not touch '{support}'"
    carried = sum(point.force * point.normal[2] for point in points)
    weight = cell.model.body_subtreemass[cell.body_id(name)] * -cell.model.opt.gravity[2]
    return "" if carried >= MIN_SUPPORT * weight else f"'{support}' does not carry '{name}'"


def _why_moving(velocity: np.ndarray) -> str:
    """Describe a velocity [m/s, rad/s] that is too fast for rest; empty for one at rest."""
    linear, angular = velocity[:3], velocity[3:]
    speed, turning = math.sqrt(linear.dot(linear)), math.sqrt(angular.dot(angular))
    if not speed <= MAX_REST_SPEED:
        return f"moves at {1000 * speed:.1f} mm/s"
    if not turning <= MAX_REST_TURNING:
        return f"turns at {turning:.2f} rad/s"
    return ""


def _why_topples(cell: "Cell", name: str, velocity: np.ndarray, acceleration: np.ndarray) -> str:
    """Describe the motion of the fastest corner of an object that moves slowly; empty at rest.

    An object that topples turns about its foot, slowly at first, and ever faster.

    Args:
        cell: The cell.
        name: The object; it moves freely.
        velocity: Its linear and angular velocity, in the world [m/s, rad/s].  # (6,)
        acceleration: Its linear acceleration, in the world [m/s^2], and its angular acceleration,
            in its own frame [rad/s^2].  # (6,)
    """
    T_wo = cell.pose(name)
    lever = np.array(list(product(*zip(*extent(cell, name), strict=True)))) - T_wo.translation
    corners = velocity[:3] + np.cross(velocity[3:], lever)  # [m/s]
    speeds = np.linalg.norm(corners, axis=1)
    fastest = int(speeds.argmax())
    if not speeds[fastest] <= MAX_CORNER_SPEED:
        return f"turns: its fastest corner moves at {1000 * speeds[fastest]:.1f} mm/s"
    turning = np.cross(T_wo.rotation @ acceleration[3:], lever[fastest])
    growth = float((acceleration[:3] + turning) @ corners[fastest])  # [m^2/s^3]
    if speeds[fastest] > MIN_TOPPLING_SPEED and growth > MIN_TOPPLING * speeds[fastest]:
        return (
            f"topples: its fastest corner moves at {1000 * speeds[fastest]:.1f} mm/s, ever faster"
        )
    return ""


def _why_astray(cell: "Cell", name: str, container: str) -> str:
    """Return why an object does not touch a container and loose objects only; empty if it does."""
    points = cell.contacts.points(name)
    for point in points:
        if entity_of(point.other) != container and not _is_loose(cell, entity_of(point.other)):
            return f"'{name}' touches '{point.other}'"
    return "" if points else f"'{name}' touches nothing"


def _why_unsupported(cell: "Cell", name: str, container: str, seen: set[str]) -> str:
    """Return why an object is not supported inside a container; empty if it is.

    Args:
        cell: The cell.
        name: The object.
        container: The container.
        seen: The container, and the objects that are being checked.
    """
    seen.add(name)
    if reason := _why_astray(cell, name, container):
        return reason
    points = cell.contacts.points(name)
    lower, upper = extent(cell, name)
    size, centre = upper - lower, 0.5 * (lower + upper)
    depths = [_distance(cell, g, centre, _DOWN) for g in collision_geoms(cell, container)]
    below = min((depth for depth in depths if depth >= 0.0), default=math.inf)
    if below == math.inf or not _is_inside(cell, container, centre + below * _DOWN, size):
        return f"'{name}' is not inside '{container}'"
    inside: set[str] = set()
    for point in points:
        other = entity_of(point.other)
        carries = other not in inside and point.normal[2] >= MIN_SLOPE
        if carries and _is_inside(cell, container, point.position, size):
            if other == container:
                return ""
            inside.add(other)
    for other in sorted(inside - seen):
        if not _why_unsupported(cell, other, container, seen):
            return ""
    return f"'{name}' does not rest on the inside of '{container}'"


def _is_inside(cell: "Cell", container: str, place: np.ndarray, size: np.ndarray) -> bool:
    """Return whether a container surrounds an object of a size [m] that rests at a place [m]."""
    points = place - np.linspace(RIM, max(size[2], RIM), _LEVELS)[:, None] * _DOWN
    return surrounds(cell, container, points, width=float(min(size[:2])))


def _distance(cell: "Cell", geom: int, point: np.ndarray, ray: np.ndarray) -> float:
    """Return the distance from a point to a geom along a ray [m]; negative if it misses."""
    model, data = cell.model, cell.data
    kind = int(model.geom_type[geom])
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        return float(mujoco.mj_rayMesh(model, data, geom, point, ray))
    if kind == mujoco.mjtGeom.mjGEOM_HFIELD:
        return float(mujoco.mj_rayHfield(model, data, geom, point, ray))
    pose = data.geom_xpos[geom], data.geom_xmat[geom]
    return float(mujoco.mju_rayGeom(*pose, model.geom_size[geom], point, ray, kind))


def _is_loose(cell: "Cell", name: str) -> bool:
    """Return whether an entity is a freely moving object, neither a robot nor fixed."""
    return cell.is_free(name) and not isinstance(cell.entities[name], MonitoredEntity)
