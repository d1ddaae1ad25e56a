"""Conservative advancement: skipping collision checks with large enough distances."""

from typing import NamedTuple

import mujoco
import numpy as np

from .collision_model import CollisionModel, pair_margins
from .motion_bounds import MotionBounds, norms
from .robot_geometry import RobotGeometry

WINDOWS = (48, 12)  # configurations per distance query; the second if the first is inconclusive
CONTACT_ERROR = 4e-4  # [m] by which contacts at corners may be nearer than the distance query
BOX_FACTOR = float(np.sqrt(3.0))
"""Largest ratio of the distance of two boxes, corner to corner, to the distance of MuJoCo's
contact, the gap along an axis of one of the boxes."""
_GEOM = mujoco.mjtGeom
_PLANE, _BOX = int(_GEOM.mjGEOM_PLANE), int(_GEOM.mjGEOM_BOX)
_FIELDS = [int(_GEOM.mjGEOM_HFIELD), int(_GEOM.mjGEOM_SDF)]  # no distance queries for these


class ConservativeAdvancement:
    """Measures distances at some configurations of a path to skip the checks of their neighbours.

    At another configuration, the distance of a pair of geoms is smaller than the measured one by at
    most the displacement of one geom relative to the other (`MotionBounds`). While the remainder
    exceeds the required clearance, there is no contact (Mirtich 1996; Schwarzer, Saha and Latombe
    2005).

    Most pairs are excluded by their bounding spheres, most others by their bounding boxes; MuJoCo
    measures the rest. For arms that are not a chain of hinges, all configurations are unknown.

    Args:
        source: The model of the simulation.
        scratch: The model whose collision detection is skipped; its data are changed.
        geometry: The robot.
        joints: Ids of the arm's joints, from the base on.  # (nq,)
    """

    def __init__(
        self,
        source: mujoco.MjModel,
        scratch: CollisionModel,
        geometry: RobotGeometry,
        joints: np.ndarray,
    ) -> None:
        self._source, self._scratch = source, scratch
        self._geometry, self._joints = geometry, joints
        self._enabled = False

    def select(self, pairs: np.ndarray, link: np.ndarray | None) -> None:
        """Select the pairs of geoms to measure.

        Args:
            pairs: Mask of the pairs that are checked for collisions.  # (ngeom, ngeom)
            link: Link of each geom; None if the arm is not a chain of hinges.  # (ngeom,)
        """
        model = self._source
        field = np.isin(model.geom_type, _FIELDS)
        unknown = pairs & (field[:, np.newaxis] | field)
        self._enabled = False
        if link is None or model.nflex or unknown.any():
            return
        self._enabled = True
        self._link = np.where(pairs.any(axis=1), link, 0)
        first, second = np.nonzero(np.triu(pairs))
        swap = self._link[first] > self._link[second]
        self._pairs = np.where(swap, (second, first), (first, second))  # (2, npair)
        self._pair_links = self._link[self._pairs]
        kind = model.geom_type[self._pairs]
        self._factor = np.where((kind == _BOX).all(axis=0), BOX_FACTOR, 1.0)
        self._geoms, index = np.unique(self._pairs, return_inverse=True)
        self._index = index.reshape(2, -1)  # indices of the pairs in _geoms
        self._flat_index = np.ravel_multi_index(tuple(self._index), 2 * self._geoms.shape)
        self._radii = model.geom_rbound[self._pairs].sum(axis=0)
        self._with_plane = (kind == _PLANE).any(axis=0)

    def refresh(self) -> None:
        """Discard bounds and margins: gripper, held object and inflation may have changed."""
        self._bounds: MotionBounds | None = None
        self._margins: np.ndarray | None = None

    def known_free(self, path: np.ndarray, clearance: np.ndarray) -> np.ndarray:
        """Return which configurations of a path are certainly free.

        Args:
            path: Configurations [rad].  # (n, nq)
            clearance: Required distance of each pair of geoms [m], -inf for none.
                # (ngeom, ngeom)

        Returns:
            True for free configurations, False for unknown ones.  # (n,)
        """
        n, nq = path.shape
        if not self._enabled or n <= WINDOWS[-1]:
            return np.zeros(n, dtype=bool)
        if self._margins is None:
            margins = pair_margins(self._scratch.model)[tuple(self._pairs)]
            self._margins = margins - self._scratch.padding
        least = clearance[tuple(self._pairs)]
        least = np.where(least > 0.0, self._factor * least, least) + self._margins + CONTACT_ERROR
        padded = np.concatenate([path, np.repeat(path[-1:], -n % WINDOWS[0], axis=0)])
        free = np.zeros(len(padded), dtype=bool)
        candidate = ~free
        for size in WINDOWS:
            rows = np.flatnonzero((candidate & ~free).reshape(-1, size)[:, 0])
            if not len(rows):
                break
            window_free, blocked = self._check_windows(padded.reshape(-1, size, nq)[rows], least)
            free.reshape(-1, size)[rows] = window_free[:, np.newaxis]
            candidate.reshape(-1, size)[rows] = ~blocked[:, np.newaxis]
        return free[:n]

    def _check_windows(
        self, windows: np.ndarray, least: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Measure distances at the centres of windows.

        Args:
            windows: Configurations [rad].  # (m, size, nq)
            least: Required distance of each pair [m].  # (npair,)

        Returns:
            Whether a window is free, and whether its centre is in collision.  # (m,), (m,)
        """
        middles = windows[:, windows.shape[1] // 2]
        dq = windows - middles[:, np.newaxis]
        scratch, geoms, bounds = self._scratch, self._geoms, self._motion_bounds()
        data = scratch.data
        frames, positions, matrices = [], [], []
        for q in middles:
            self._geometry.write(data.qpos, q)
            scratch.update_kinematics()
            frames.append(bounds.frames(data))
            positions.append(data.geom_xpos[geoms])
            matrices.append(data.geom_xmat[geoms])
        m, nq = middles.shape
        displacement = np.zeros((m, nq + 1, nq + 1))
        displacement[:, 0, 1:] = bounds.displacement(frames, dq).max(axis=1)
        displacement[:, 1:, 1:] = bounds.relative_displacement(np.abs(dq).max(axis=1))
        needed = least + displacement[:, self._pair_links[0], self._pair_links[1]]
        return self._measure(np.array(positions), np.array(matrices), least, needed)

    def _motion_bounds(self) -> MotionBounds:
        """Return the bounds of displacements of the links."""
        if self._bounds is None:
            geometry, scratch = self._geometry, self._scratch
            geometry.write(scratch.data.qpos, np.array(geometry.robot.description.home))
            scratch.update_kinematics()
            self._bounds = MotionBounds(scratch.model, scratch.data, self._joints, self._link)
        return self._bounds

    def _measure(
        self, positions: np.ndarray, matrices: np.ndarray, least: np.ndarray, needed: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return where all pairs have the needed distance, and where one is below the required one.

        Args:
            positions: Positions of the geoms [m].  # (m, ngeom, 3)
            matrices: Rotation matrices of the geoms.  # (m, ngeom, 9)
            least: Required distance of each pair [m].  # (npair,)
            needed: Required distance plus the displacement in the window [m].  # (m, npair)
        """
        free, blocked = np.ones(len(needed), dtype=bool), np.zeros(len(needed), dtype=bool)
        rows, columns = np.nonzero(self._close_by_spheres(positions, matrices, needed))
        lower = self._box_distances(positions, matrices, rows, columns, needed[rows, columns])
        excess = lower - needed[rows, columns]
        model, data = self._scratch.model, self._scratch.data
        for i in np.argsort(excess, kind="stable").tolist():
            if excess[i] >= 0.0:
                break
            row, column = rows[i], columns[i]
            if not free[row]:
                continue
            pair = self._pairs[:, column]
            for k, geom in zip(self._index[:, column], pair, strict=True):
                data.geom_xpos[geom], data.geom_xmat[geom] = positions[row, k], matrices[row, k]
            distance = mujoco.mj_geomDistance(
                model, data, pair[0], pair[1], needed[row, column], None
            )
            if distance < needed[row, column]:
                free[row], blocked[row] = False, distance < least[column]
        return free, blocked

    def _close_by_spheres(
        self, positions: np.ndarray, matrices: np.ndarray, needed: np.ndarray
    ) -> np.ndarray:
        """Return the mask of pairs whose bounding spheres are closer than needed.

        For planes, the distance is from the sphere to the plane.
        """  # (m, npair)
        reach = np.maximum(needed + self._radii, 0.0)
        square = np.einsum("mgi,mgi->mg", positions, positions)
        product = positions @ np.swapaxes(positions, 1, 2)
        apart = square[:, np.newaxis] + square[:, :, np.newaxis] - 2.0 * product
        apart = apart.reshape(len(apart), -1).take(self._flat_index, axis=1)
        close: np.ndarray = apart < reach * reach
        for column in np.flatnonzero(self._with_plane).tolist():
            plane, other = self._index[:, column]  # planes are fixed, so they come first
            normal = matrices[:, plane, 2::3]
            height = np.einsum("mi,mi->m", positions[:, other] - positions[:, plane], normal)
            close[:, column] = height < reach[:, column]
        return close

    def _box_distances(
        self,
        positions: np.ndarray,
        matrices: np.ndarray,
        rows: np.ndarray,
        columns: np.ndarray,
        needed: np.ndarray,
    ) -> np.ndarray:
        """Return lower bounds of the distances of pairs by their bounding boxes [m].

        Args:
            positions: Positions of the geoms [m].  # (m, ngeom, 3)
            matrices: Rotation matrices of the geoms.  # (m, ngeom, 9)
            rows: Configurations.  # (n,)
            columns: Pairs.  # (n,)
            needed: Distance beyond which the bound need not be tight [m].  # (n,)
        """  # (n,)
        aabb = self._source.geom_aabb
        sides = []
        for index, geoms in zip(self._index, self._pairs, strict=True):
            box = aabb[geoms[columns]]
            rotation = matrices[rows, index[columns]].reshape(-1, 3, 3)
            centre = positions[rows, index[columns]]
            centre = centre + (rotation @ box[:, :3, np.newaxis])[..., 0]
            sides.append(Boxes(centre, rotation, box[:, 3:]))
        first, second = sides
        distance = box_distance(first, second, needed)
        distance[self._with_plane[columns]] = -np.inf
        return distance


class Boxes(NamedTuple):
    """Oriented boxes.

    Attributes:
        centre: Centres [m].  # (n, 3)
        rotation: Axes, as columns.  # (n, 3, 3)
        half: Half sizes [m].  # (n, 3)
    """

    centre: np.ndarray
    rotation: np.ndarray
    half: np.ndarray


def box_distance(first: Boxes, second: Boxes, needed: np.ndarray) -> np.ndarray:
    """Return a lower bound of the distance of oriented boxes [m], negative if they may overlap.

    It is the larger of the gap along the face normals of both boxes (separating axes without cross
    products of edges) and the distance between one box and the bounding sphere of the other.

    Args:
        first: n boxes.
        second: n boxes.
        needed: Distance beyond which the bound need not be tight [m].  # (n,)
    """  # (n,)
    between = second.centre - first.centre
    beyond_first = np.abs(_in_box_frame(first, between)) - first.half
    beyond_second = np.abs(_in_box_frame(second, between)) - second.half
    bound = np.maximum(
        norms(np.maximum(beyond_first, 0.0)) - norms(second.half),
        norms(np.maximum(beyond_second, 0.0)) - norms(first.half),
    )
    rows = np.flatnonzero(bound < needed)
    overlap = np.abs(np.swapaxes(first.rotation[rows], -1, -2) @ second.rotation[rows])
    gaps_first = beyond_first[rows] - (overlap @ second.half[rows, :, np.newaxis])[..., 0]
    gaps_second = beyond_second[rows] - (first.half[rows, np.newaxis] @ overlap)[:, 0]
    gaps = np.maximum(gaps_first.max(axis=-1), gaps_second.max(axis=-1))
    bound[rows] = np.maximum(bound[rows], gaps)
    return bound


def _in_box_frame(boxes: Boxes, vectors: np.ndarray) -> np.ndarray:
    return (vectors[..., np.newaxis, :] @ boxes.rotation)[..., 0, :]
