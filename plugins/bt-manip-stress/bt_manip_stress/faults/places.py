"""Positions of objects and obstacles that appear in the cell."""

import math
from collections.abc import Iterator
from contextlib import suppress

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import CellError, Region, as_object, entity_of

from .fault import FaultContext, FaultError

REACH = (0.25, 0.46)
"""Distances from the base within reach from above, relative to the arm's length."""

FARTHEST = 0.4
"""Largest horizontal displacement of an object [m]."""

EDGE = 0.03
"""Smallest distance of an object's centre from the edge of its support and other objects [m]."""

BETWEEN = 0.35
"""Height of an obstacle's centre above the line from the object to the container [m]."""

POSITION_ATTEMPTS = 1000
"""Maximum number of random positions."""

SIDES = 8
"""Number of directions in which the support around an object is checked."""


class Places:
    """The positions on surfaces at which a robot reaches an object from above.

    Args:
        context: The run.
        name: The object.
        distance: Smallest horizontal distance from its present pose [m].
    """

    def __init__(self, context: FaultContext, name: str, distance: float) -> None:
        cell = context.cell
        self._context, self._distance = context, distance
        self._declared = as_object(cell.find(name))
        self._here = cell.pose(name).translation[:2]
        self._base = cell.pose(context.robot.name).translation[:2]
        self._near, self._far = (share * _length(context) for share in REACH)
        self._body = cell.body_id(name)

    def sample(self) -> Iterator[pin.SE3]:
        """Yield random upright poses of the object at these positions."""
        rng = self._context.rng
        for _ in range(POSITION_ATTEMPTS):
            r, angle = rng.uniform(self._near, self._far), rng.uniform(-math.pi, math.pi)
            x, y = self._base + r * np.array([math.cos(angle), math.sin(angle)])
            height = self.height_at(x, y)
            if height is None:
                continue
            z = height + self._declared.rest_height
            middle_x, middle_y, _ = self._declared.centre_offset
            yield Region((x, x), (y, y), (z, z), middle=(middle_x, middle_y)).sample(rng)

    def height_at(self, x: float, y: float) -> float | None:
        """Return the height of the surface at one of these positions [m]; None elsewhere."""
        reach = math.hypot(x - self._base[0], y - self._base[1])
        moved = math.hypot(x - self._here[0], y - self._here[1])
        if not self._near <= reach <= self._far or not self._distance <= moved <= FARTHEST:
            return None
        height = _support(self._context, x, y, self._body)
        ring = 2.0 * math.pi * np.arange(SIDES) / SIDES
        around = zip(x + EDGE * np.cos(ring), y + EDGE * np.sin(ring), strict=True)
        level = all(_support(self._context, *one, self._body) == height for one in around)
        return height if level else None


def add_obstacle(
    context: FaultContext, size: tuple[float, float, float], distance: float, clearance: float
) -> str:
    """Add a fixed block ahead of the tool, or between the object and a container.

    Args:
        context: The run.
        size: Lengths along x, y and z [m].
        distance: Smallest distance ahead of the tool on the arm's path [m].
        clearance: Smallest horizontal distance from the object, containers and the tool, so that
            there is a path around it [m].

    Returns:
        Its name.

    Raises:
        FaultError: If there is no such position.
    """
    cell = context.cell
    keep = [cell.pose(name).translation for name in _targets(context)]
    keep.append(context.robot.robot.tool_pose.translation)
    for position in _ahead(context, distance):
        gaps = [math.hypot(*(position - one)[:2]) for one in keep]
        if min(gaps) < clearance + 0.5 * math.hypot(*size[:2]):
            continue
        bottom = position - np.array([0.0, 0.0, 0.5 * size[2]])
        block = context.station.models.nominal("wall", size=size)
        try:
            name = cell.add(block, pin.SE3(np.eye(3), bottom), name="obstacle", overlap=0.0)
        except CellError:
            continue
        if not _blocks_target(context, name):
            return name
        cell.remove(name)
    raise FaultError("there is no free place for an obstacle with a path around it")


def _blocks_target(context: FaultContext, name: str) -> bool:
    """Return whether an entity collides with the arm at the end of its motion."""
    arm = context.robot.arm
    if arm.world is None:
        return False
    arm.world.refresh()
    pairs = arm.world.collisions(arm.target)
    return any(entity_of(pair.second) == name for pair in pairs)


def _targets(context: FaultContext) -> Iterator[str]:
    for find in (context.find_object, context.find_container):
        with suppress(FaultError):
            yield find()


def _ahead(context: FaultContext, distance: float) -> Iterator[np.ndarray]:
    """Yield positions on the path of the tool, then between object and container [m]."""
    follower, model = context.robot.arm.follower, context.robot.arm.model
    tool = context.robot.robot.tool_pose.translation
    for q in follower.ahead(np.arange(0.0, follower.remaining, 0.02)):
        position = model.pose(q).translation.copy()
        if np.linalg.norm(position - tool) >= distance:
            yield position
    ends = [context.cell.pose(name).translation for name in _targets(context)]
    if len(ends) == 2:
        for share in (0.5, 0.4, 0.6, 0.3, 0.7):
            between = ends[0] + share * (ends[1] - ends[0])
            yield between + np.array([0.0, 0.0, BETWEEN])


def _length(context: FaultContext) -> float:
    """Return the largest sampled horizontal distance of the tool from the base [m]."""
    model, limits = context.robot.arm.model, context.robot.robot.limits
    lower, upper = limits.sampling_bounds()
    base = context.cell.pose(context.robot.name).translation
    rng = np.random.default_rng(0)
    tools = [model.pose(rng.uniform(lower, upper)).translation - base for _ in range(500)]
    return max(float(np.linalg.norm(tool)) for tool in tools)


def _support(context: FaultContext, x: float, y: float, without: int) -> float | None:
    """Return the height of a surface at a position [m], without a body; None if occupied."""
    cell = context.cell
    above = float(cell.pose(context.robot.name).translation[2]) + 1.5
    geom = np.zeros(1, dtype=np.int32)
    start, down = np.array([x, y, above]), np.array([0.0, 0.0, -1.0])
    gap = mujoco.mj_ray(cell.model, cell.data, start, down, None, 1, without, geom)
    if gap < 0.0:
        return None
    owner = entity_of(cell.model.body(cell.model.geom_bodyid[geom[0]]).name)
    if owner not in cell.entities or as_object(cell.find(owner)).surface_height is None:
        return None
    height = cell.surface_height(owner)
    return height if abs(above - gap - height) < 1e-3 else None
