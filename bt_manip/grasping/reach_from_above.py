"""Where an arm reaches from above: the part of a surface to pick from, and above containers."""

import contextlib
from collections import deque
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.arm import MARGIN, Arm
from bt_manip.cell import Cell, CellError, Region, extent
from bt_manip.spatial import pointing_down

REFERENCE_AREA = (0.2, 0.4, -0.3, 0.3)
"""Area of the pick and place task, x_min, x_max, y_min, y_max [m], where it is within reach."""

APPROACH = 0.1
"""Height above a grasp from which the tool comes down straight [m]."""

DROP_HEIGHTS = (0.25, 0.22, 0.19, 0.16, 0.13, 0.1)
"""Heights over a container's bottom to drop from, the preferred one first [m]."""

_CLEAR = 3  # of these are above the rim of the reference task's basket, with a cube in the gripper
NEAREST = 0.15  # [m] from the base's axis to the middle of a container
_SHIFT = 0.03  # [m] between the positions of a container that are tried
DIVISIONS = 18  # squares of the grid within the arm's length
MIN_SIDE = 0.02  # [m] of a square
_STEPS = 2  # of the straight approach that are checked
_MAX_STEP = 1.0  # [rad] of a joint between them
_YAWS = (0.0, np.pi / 4)  # [rad] of an object with four sides: the least and the most turned
_RESTARTS = 4  # of inverse kinematics where no neighbour's solution leads to one
_SPACING = 3  # of the points that are searched with restarts
_ATTEMPTS = 2  # from neighbours' solutions


class ReachFromAbove:
    """Finds where an arm reaches down with its tool, clear of itself and of all fixed objects.

    What it finds depends on the arm, the fixed objects and the surface only, and is computed once
    for each arrangement of these: at most some hundred points, each by bounded searches.
    """

    def __init__(self, arm: Arm) -> None:
        """Find it for an arm.

        Args:
            arm: The arm, compiled into a cell.
        """
        self._arm = arm
        self._known: dict[tuple[float, bytes, bytes], Region] = {}

    def area(self, cell: Cell, surface: str, height: float) -> Region:
        """Return the part of a surface that the arm can pick objects from.

        This is `REFERENCE_AREA` if all of it is within reach, or else all squares of a grid at
        whose corners and middles the tool points down, reaches the height and comes down to it.

        Args:
            cell: The cell.
            surface: Name of the object with the surface.
            height: Height of the tool above the surface at a grasp, rounded to micrometres [m].

        Raises:
            CellError: If there is no such object or it has no surface, or the arm reaches nothing.
        """
        height = round(height, 6)
        key = height, _bounds(cell, surface), _fixed_content(cell)
        if key not in self._known:
            self._known[key] = self._find_area(cell, surface, height)
        return self._known[key]

    def place_container(self, cell: Cell, name: str) -> None:
        """Move a fixed container towards the arm until the arm can drop into it.

        It stays where it is if the tool reaches, pointing down, one of `DROP_HEIGHTS` above it, or
        if no position on the straight line to the arm's base allows that.

        Args:
            cell: The cell.
            name: Name of the container.
        """
        T_wc = cell.pose(name)
        base, _ = self._base()
        offset = T_wc.translation - base
        distance = float(np.hypot(*offset[:2]))
        if self._arm.world is not None:
            self._arm.world.refresh(fixed_only=True)
        if self._can_drop(T_wc.translation, DROP_HEIGHTS):
            return
        shifts = np.arange(_SHIFT, distance - NEAREST, _SHIFT)
        for heights in (DROP_HEIGHTS[:_CLEAR], DROP_HEIGHTS):
            within = 0
            for shift in shifts:
                moved = T_wc.translation - shift / distance * np.array([*offset[:2], 0.0])
                within = within + 1 if self._can_drop(moved, heights) else 0
                if within > 1:  # not at the very end of its reach
                    with contextlib.suppress(CellError):  # something stands there
                        cell.move(name, pin.SE3(T_wc.rotation, moved))
                        return

    def _can_drop(self, bottom: np.ndarray, heights: Sequence[float]) -> bool:
        ik, home = self._arm.ik, self._arm.model.home
        for height in heights:
            for k in range(4):
                T_wt = pointing_down(bottom + np.array([0.0, 0.0, height]), k * np.pi / 4)
                if next(ik.nearest_first(T_wt, home, restarts=1, margin=MARGIN), None):
                    return True
        return False

    def _find_area(self, cell: Cell, surface: str, height: float) -> Region:
        low, high = extent(cell, surface)
        z = cell.surface_height(surface)
        if self._arm.world is not None:
            self._arm.world.refresh(fixed_only=True)
        x_min, x_max, y_min, y_max = REFERENCE_AREA
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
        """Return a configuration for each point of a grid that is reached, by its indices.

        Every third point of every third row is searched with restarts, all others from the
        solutions of their neighbours.
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
        q = self._arm.model.home
        for x, y in points:
            found = self._reach((x, y, z), q)
            if found is None:
                return False
            q = found
        return True

    def _reach(self, position: tuple[float, float, float], q0: np.ndarray) -> np.ndarray | None:
        """Return the configuration over a position from which the tool reaches it at any yaw.

        Args:
            position: Position of the tool at the grasp, in the world [m].
            q0: Where to search first [rad].  # (nq,)
        """
        found: np.ndarray | None = q0
        for yaw in _YAWS:
            if found is not None:
                found = self._turned(position, yaw, found)
        return found

    def _turned(
        self, position: tuple[float, float, float], yaw: float, q0: np.ndarray
    ) -> np.ndarray | None:
        """Return a configuration over a position for one yaw, up to quarter turns."""
        found = self._approach(position, yaw, q0, 0)
        return self._approach(position, yaw, q0, _RESTARTS) if found is None else found

    def _approach(
        self, position: tuple[float, float, float], yaw: float, q0: np.ndarray, restarts: int
    ) -> np.ndarray | None:
        """Return a configuration over a position from which the tool comes down straight.

        Args:
            position: Position of the tool at the grasp, in the world [m].
            yaw: Of the tool, up to quarter turns [rad].
            q0: Where to search first [rad].  # (nq,)
            restarts: Of the search for each of two quarter turns, those nearest to `q0`.
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
        """Return whether the arm is free at a pose, and on the straight line down from it."""
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

    def _free(self, q: np.ndarray) -> bool:
        return self._arm.world is None or not self._arm.world.collisions(q)

    def _base(self) -> tuple[np.ndarray, float]:
        """Return the position of the first joint, and the length of the stretched arm [m]."""
        model = self._arm.model
        slides = [unit == "m" for unit in model.units]
        travel = np.maximum(np.abs(model.limits.lower), np.abs(model.limits.upper))[slides]
        length = float(sum(model.link_lengths) + sum(travel))
        return np.array(model.model.jointPlacements[1].translation), length


def _bounds(cell: Cell, surface: str) -> bytes:
    """Return the bounding box and the height of a surface, as bytes."""
    return np.array([*np.ravel(extent(cell, surface)), cell.surface_height(surface)]).tobytes()


def _fixed_content(cell: Cell) -> bytes:
    """Return poses and shapes of all that does not move freely in the compiled model, as bytes."""
    model, data = cell.model, cell.data
    root = model.body_rootid
    fixed = model.body_dofnum[root] != 6  # (nbody,)
    geoms = fixed[model.geom_bodyid]
    parts = [data.mocap_pos, data.mocap_quat, model.body_pos[fixed], model.body_quat[fixed]]
    for field in ("type", "pos", "quat", "size", "aabb", "contype", "conaffinity"):
        parts.append(getattr(model, f"geom_{field}")[geoms])
    return b"".join(part.tobytes() for part in parts)
