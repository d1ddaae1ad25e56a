"""The area that an arm reaches from above, on surfaces and above containers."""

import contextlib
from collections import deque
from collections.abc import Sequence
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.arm import MARGIN, Arm
from bt_manip.cell import Cell, CellError, Region, as_object, entity_of, extent
from bt_manip.spatial import pointing_down

REFERENCE_AREA = (0.2, 0.4, -0.3, 0.3)
"""Area of the pick-and-place task if within reach: x_min, x_max, y_min, y_max [m]."""

APPROACH = 0.1
"""Height above a grasp from which the tool descends straight [m]."""

DROP_HEIGHTS = (0.25, 0.22, 0.19, 0.16, 0.13, 0.1)
"""Heights over a container's bottom for drops, the preferred one first [m]."""

_CLEAR = 3  # number of these heights that clear the rim of the task's basket with a held cube
NEAREST = 0.15  # [m] minimum distance of a container's centre from the base's axis
_SHIFT = 0.03  # [m] between tested positions of a container
DIVISIONS = 18  # number of grid squares within the arm's length
MIN_SIDE = 0.02  # [m] minimum side of a square
_STEPS = 2  # checked steps of the straight approach
_MAX_STEP = 1.0  # [rad] maximum change of a joint in a step
_YAWS = (0.0, np.pi / 4)  # [rad] extreme yaws of an object with four sides
_RESTARTS = 4  # restarts of inverse kinematics without a neighbour's solution
_SPACING = 3  # spacing of the grid points that are searched with restarts
_ATTEMPTS = 2  # maximum number of neighbours' solutions used as initial guesses


class ReachFromAbove:
    """Area that an arm reaches with its tool pointing down, without any collision.

    It depends on the arm, fixed objects and the surface only, and is computed once for each
    arrangement of these: some hundred points at most, each by bounded searches.

    Args:
        arm: The arm, compiled into a cell.
    """

    def __init__(self, arm: Arm) -> None:
        self._arm = arm
        self._known: dict[tuple[Any, ...], Region] = {}

    def area(
        self,
        cell: Cell,
        surface: str,
        height: float,
        preferred: tuple[float, float, float, float] = REFERENCE_AREA,
    ) -> Region:
        """Return the part of a surface from which the arm can pick objects.

        This is the preferred area if all of it is within reach. Otherwise it consists of the
        squares of a grid at whose corners and centres the tool, pointing down, can descend to the
        height.

        Args:
            cell: The cell.
            surface: Name of the object with the surface.
            height: Height of the tool above the surface at a grasp, rounded to micrometres [m].
            preferred: x_min, x_max, y_min and y_max in the world [m].

        Raises:
            CellError: If there is no such object, it has no surface, or no part is within reach.
        """
        height = round(height, 6)
        bounds = *np.ravel(extent(cell, surface)).tolist(), cell.surface_height(surface)
        key = height, preferred, bounds, _fixed_content(cell)
        if key not in self._known:
            self._known[key] = self._find_area(cell, surface, height, preferred)
        return self._known[key]

    def reaches(self, cell: Cell, name: str, T_wo: pin.SE3 | None = None) -> bool:
        """Return whether the arm reaches an object's ``tool_targets`` without collisions.

        Only fixed obstacles count; ``tool_targets``: see `bt_manip.cell.CellObject`.

        Args:
            cell: The cell.
            name: Name of the object.
            T_wo: Its pose in the world; None: the present pose.
        """
        T_wo = cell.pose(name) if T_wo is None else T_wo
        if self._arm.world is not None:
            self._arm.world.refresh(fixed_only=True)
        declared = as_object(cell.find(name))
        if declared.category == "container":
            return self._can_drop(T_wo, DROP_HEIGHTS)
        targets = [[T_wo * T_ot for T_ot in poses] for poses in declared.tool_targets]
        if not targets:
            centre = T_wo.act(np.array(declared.centre_offset))
            targets = [_downward(centre + (0.0, 0.0, z)) for z in (0.0, APPROACH)]
        q: np.ndarray | None = self._arm.model.home
        for poses in targets:
            if q is not None:
                q = self._first_free(poses, q, name)
        return q is not None

    def _first_free(self, poses: Sequence[pin.SE3], q0: np.ndarray, used: str) -> np.ndarray | None:
        """Return a configuration at one of several poses, free of collisions except with `used`."""
        for restarts in (0, _RESTARTS):
            for T_wt in poses:
                for found in self._arm.ik.nearest_first(T_wt, q0, restarts=restarts, margin=MARGIN):
                    if self._free(found.q, used):
                        return np.array(found.q)
        return None

    def place(self, cell: Cell, name: str, T_wo: pin.SE3 | None = None) -> None:
        """Move an object towards or away from the arm until it is within reach.

        It is not moved if the arm `reaches` it at its pose, or nowhere on the straight line from
        the arm's base.

        Args:
            cell: The cell.
            name: Name of the object.
            T_wo: Original pose in the world if it is not free; None: the present pose.

        Raises:
            CellError: If the original pose is not free, and there is no other one within reach.
        """
        taken = T_wo is not None
        T_wo = cell.pose(name) if T_wo is None else T_wo
        if not taken and self.reaches(cell, name):
            return
        base, length = self._base()
        offset = T_wo.translation - base
        distance = float(np.hypot(*offset[:2]))
        direction = np.array([*offset[:2], 0.0]) / distance
        if as_object(cell.find(name)).category == "container":
            tests = [
                partial(self._can_drop, heights=heights)
                for heights in (DROP_HEIGHTS[:_CLEAR], DROP_HEIGHTS)
            ]
        else:
            tests = [partial(self.reaches, cell, name)]
        for reached in tests:
            for sign in (-1.0, 1.0):
                within, most = 0, distance - NEAREST if sign < 0 else length - distance
                for shift in np.arange(_SHIFT, most, _SHIFT):
                    at = T_wo.translation + sign * shift * direction
                    T_moved = pin.SE3(T_wo.rotation, at)
                    within = within + 1 if reached(T_moved) else 0
                    if within > 1:  # not at the end of the reach
                        with contextlib.suppress(CellError):  # not free
                            cell.move(name, T_moved)
                            return
        if taken:
            raise CellError(f"there is no free place for '{name}' within reach of the arm")

    def _can_drop(self, T_wc: pin.SE3, heights: Sequence[float]) -> bool:
        bottom = T_wc.translation
        ik, home = self._arm.ik, self._arm.model.home
        for height in heights:
            for T_wt in _downward(bottom + np.array([0.0, 0.0, height])):
                if next(ik.nearest_first(T_wt, home, restarts=1, margin=MARGIN), None):
                    return True
        return False

    def _find_area(
        self, cell: Cell, surface: str, height: float, preferred: tuple[float, ...]
    ) -> Region:
        low, high = extent(cell, surface)
        z = cell.surface_height(surface)
        if self._arm.world is not None:
            self._arm.world.refresh(fixed_only=True)
        x_min, x_max, y_min, y_max = preferred
        inside = low[0] <= x_min and x_max <= high[0] and low[1] <= y_min and y_max <= high[1]
        points = [
            (x, y) for x in np.linspace(x_min, x_max, 3) for y in np.linspace(y_min, y_max, 3)
        ]
        if inside and self._all_reached(points, z + height):
            return Region((x_min, x_max), (y_min, y_max), (z, z))
        middle, length = self._base()
        side = max(length / DIVISIONS, MIN_SIDE)
        xs, ys = (
            np.arange(max(low[i], middle[i] - length), min(high[i], middle[i] + length), side)
            for i in (0, 1)
        )
        reached = self._reached_grid(xs, ys, z + height)
        squares = []
        for (i, j), q in reached.items():
            point = float(xs[i] + side / 2), float(ys[j] + side / 2)
            corners = {(i + 1, j), (i, j + 1), (i + 1, j + 1)}
            if (
                corners <= reached.keys()
                and self._turned((*point, z + height), _YAWS[1], q) is not None
            ):
                squares.append(point)
        if not squares:
            raise CellError(
                f"the arm reaches no part of '{surface}' from above: place its base so that the "
                "tool can point down there ([base] of its description), or give a region"
            )
        x, y = (np.array(squares)[:, i] for i in (0, 1))
        half = side / 2
        return Region(
            (float(x.min()) - half, float(x.max()) + half),
            (float(y.min()) - half, float(y.max()) + half),
            (z, z),
            squares=tuple(squares),
            side=float(side),
        )

    def _reached_grid(
        self, xs: np.ndarray, ys: np.ndarray, z: float
    ) -> dict[tuple[int, int], np.ndarray]:
        """Return a configuration for each reachable point of a grid, by its indices.

        Every third point of every third row is solved with restarts, all others from the solutions
        of their neighbours.
        """
        reached: dict[tuple[int, int], np.ndarray] = {}
        last = self._arm.model.home
        for i in range(1, len(xs), _SPACING):
            for j in range(1, len(ys), _SPACING):
                found = self._approach((xs[i], ys[j], z), 0.0, last, _RESTARTS)
                if found is not None:
                    reached[i, j] = last = found
        attempts = np.zeros((len(xs), len(ys)), dtype=int)
        queue = deque(reached)
        while queue:
            i, j = queue.popleft()
            for k, m in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
                inside = 0 <= k < len(xs) and 0 <= m < len(ys)
                if not inside or (k, m) in reached or attempts[k, m] == _ATTEMPTS:
                    continue
                attempts[k, m] += 1
                found = self._approach((xs[k], ys[m], z), 0.0, reached[i, j], 0)
                if found is not None:
                    reached[k, m] = found
                    queue.append((k, m))
        return reached

    def _all_reached(self, points: list[tuple[float, float]], z: float) -> bool:
        """Return whether the arm can descend to all points in turn, at any yaw."""
        q = self._arm.model.home
        for (x, y), yaw in product(points, _YAWS):
            found = self._turned((x, y, z), yaw, q)
            if found is None:
                return False
            q = found
        return True

    def _turned(
        self, position: tuple[float, float, float], yaw: float, q0: np.ndarray
    ) -> np.ndarray | None:
        """Return a configuration over a position at a yaw, up to quarter turns."""
        found = self._approach(position, yaw, q0, 0)
        return self._approach(position, yaw, q0, _RESTARTS) if found is None else found

    def _approach(
        self, position: tuple[float, float, float], yaw: float, q0: np.ndarray, restarts: int
    ) -> np.ndarray | None:
        """Return a configuration over a position from which the tool can descend straight.

        The two quarter turns of the yaw that are nearest to `q0` are tried.
        """
        ik, up = self._arm.ik, np.array([0.0, 0.0, APPROACH])
        above = [pointing_down(position + up, yaw + k * np.pi / 2) for k in range(4)]
        R = self._arm.model.pose(q0).rotation
        above.sort(key=lambda T_wt: -float(np.trace(T_wt.rotation.T @ R)))
        for T_wt in above[:2]:
            for found in ik.nearest_first(T_wt, q0, restarts=restarts, margin=MARGIN):
                if self._comes_down(T_wt, found.q):
                    return found.q
        return None

    def _comes_down(self, T_wt: pin.SE3, q: np.ndarray) -> bool:
        """Return whether the arm is free at a pose and on the straight line down from it."""
        ik = self._arm.ik
        if not self._free(q):
            return False
        for k in range(1, _STEPS + 1):
            down = np.array([0.0, 0.0, k / _STEPS * APPROACH])
            target = pin.SE3(T_wt.rotation, T_wt.translation - down)
            found = ik.follow(target, q, max_step=_MAX_STEP, retry=False)
            if not found.solved or not self._free(found.q):
                return False
            q = found.q
        return True

    def _free(self, q: np.ndarray, used: str = "") -> bool:
        """Return whether the arm is free of collisions, except with a used object."""
        pairs = [] if self._arm.world is None else self._arm.world.collisions(q)
        return all(used in (entity_of(pair.first), entity_of(pair.second)) for pair in pairs)

    def _base(self) -> tuple[np.ndarray, float]:
        """Return the position of the first joint, and the length of the stretched arm [m]."""
        model = self._arm.model
        slides = [unit == "m" for unit in model.units]
        travel = np.maximum(np.abs(model.limits.lower), np.abs(model.limits.upper))[slides]
        length = float(sum(model.link_lengths) + sum(travel))
        return np.array(model.model.jointPlacements[1].translation), length


def _downward(position: np.ndarray) -> list[pin.SE3]:
    """Return tool poses at a position, pointing down, with yaws over half a turn."""
    return [pointing_down(position, k * np.pi / 4) for k in range(4)]


def _fixed_content(cell: Cell) -> bytes:
    """Return poses and shapes of all fixed bodies in the compiled model, as bytes."""
    model, data = cell.model, cell.data
    root = model.body_rootid
    fixed = model.body_dofnum[root] != 6  # (nbody,)
    geoms = fixed[model.geom_bodyid]
    parts = [data.mocap_pos, data.mocap_quat, model.body_pos[fixed], model.body_quat[fixed]]
    for field in ("type", "pos", "quat", "size", "aabb", "contype", "conaffinity"):
        parts.append(getattr(model, f"geom_{field}")[geoms])
    return b"".join(part.tobytes() for part in parts)
