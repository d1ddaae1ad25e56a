"""Predicates on objects: at rest, in a container, on a support.

All predicates are false in a state that is not finite.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from .contacts.contact_monitor import MonitoredEntity
from .geometry import extent
from .naming import entity_of

if TYPE_CHECKING:
    from .cell import Cell

MAX_REST_SPEED = 5e-3  # [m/s] maximum speed of an object at rest
MAX_REST_TURNING = 0.2  # [rad/s] maximum angular speed: 9 mm/s at a corner of a 50 mm cube
RIM = 5e-3  # [m] contacts less than this below a container's top are on its rim, not inside
MIN_SLOPE = 0.05  # [-] minimum vertical component of the normal of a supporting contact
MIN_SUPPORT = 0.25  # [-] minimum share of an object's weight carried by a support


def at_rest(cell: "Cell", name: str) -> bool:
    """Return whether an object is at rest.

    Raises:
        CellError: If there is no such object.
    """
    return not why_not_at_rest(cell, name)


def is_in(cell: "Cell", name: str, container: str) -> bool:
    """Return whether an object is at rest inside a container.

    Its centre is within the container's outline, and it is supported by the inside of the container
    or by an object inside. It touches only the container and freely moving objects, so a gripped
    object is not in the container.

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


def is_rest_velocity(velocity: np.ndarray) -> bool:
    """Return whether a linear and angular velocity is that of an object at rest."""  # (6,)
    return not _why_moving(velocity)


def why_not_at_rest(cell: "Cell", name: str) -> str:
    """Return why an object is not at rest; empty if it is.

    Raises:
        CellError: If there is no such object.
    """
    cell.find(name)
    if not (np.isfinite(cell.data.qpos).all() and np.isfinite(cell.data.qvel).all()):
        return "the state of the cell is not finite"
    reason = _why_moving(cell.velocity(name))
    return reason and f"'{name}' {reason}"


def why_not_in(cell: "Cell", name: str, container: str) -> str:
    """Return why `is_in` does not hold; empty if it does.

    Raises:
        CellError: If there is no such object or container.
    """
    cell.find(container)
    return why_not_at_rest(cell, name) or _why_unsupported(cell, name, container, {container})


def why_not_on(cell: "Cell", name: str, support: str) -> str:
    """Return why `is_on` does not hold; empty if it does.

    Raises:
        CellError: If there is no such object or support.
    """
    cell.find(support)
    reason = why_not_at_rest(cell, name)
    if reason:
        return reason
    carried, touched = 0.0, False
    for point in cell.contacts.points(name):
        other = entity_of(point.other)
        if isinstance(cell.entities.get(other), MonitoredEntity):
            return f"'{name}' touches '{point.other}'"
        if other == support:
            touched = True
            carried += point.force * point.normal[2]
    if not touched:
        return f"'{name}' does not touch '{support}'"
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


def _why_unsupported(cell: "Cell", name: str, container: str, seen: set[str]) -> str:
    """Return why an object is not supported inside a container; empty if it is.

    Args:
        cell: The cell.
        name: The object.
        container: The container.
        seen: The container, and the objects that are being checked.
    """
    seen.add(name)
    points = cell.contacts.points(name)
    if not points:
        return f"'{name}' touches nothing"
    for point in points:
        if entity_of(point.other) != container and not _is_loose(cell, entity_of(point.other)):
            return f"'{name}' touches '{point.other}'"
    T_wc = cell.pose(container)
    lower, upper = extent(cell, container, T_wc)
    upper = upper - (0.0, 0.0, RIM)
    centre = np.mean(extent(cell, name, T_wc), axis=0)
    if (centre < lower).any() or (centre[:2] > upper[:2]).any():
        return f"'{name}' is not inside '{container}'"
    inside = set()
    for point in points:
        position = T_wc.actInv(point.position)
        supports = point.normal[2] >= MIN_SLOPE
        if supports and (position >= lower).all() and (position <= upper).all():
            inside.add(entity_of(point.other))
    if container in inside:
        return ""
    for other in sorted(inside - seen):
        if not _why_unsupported(cell, other, container, seen):
            return ""
    return f"'{name}' does not rest on the inside of '{container}'"


def _is_loose(cell: "Cell", name: str) -> bool:
    """Return whether an entity is a freely moving object, neither a robot nor fixed."""
    return cell.is_free(name) and not isinstance(cell.entities[name], MonitoredEntity)
