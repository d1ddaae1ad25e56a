"""Prove configurations free that nobody looks at, by how far the arm is from what is nearby."""

from collections.abc import Callable

import mujoco
import numpy as np
import pinocchio as pin

from .arm_motion import ArmMotion
from .collision_model import CollisionModel
from .enclosing_boxes import Boxes, apart
from .geom_pairs import distance_unknown, margins, scaled

WINDOWS = (24, 6)  # configurations around one that is measured; the latter where the first fails
DOUBT = 4e-4  # [m] by which distances may be off: contacts at corners are nearer for MuJoCo
CORNER = float(np.sqrt(3.0))  # boxes that are corner to corner are nearer for it by up to that
_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)

Carried = Callable[[np.ndarray], pin.SE3 | None]
"""Gives the pose of what is held at a configuration; None where nothing is held."""


class ConservativeAdvancement:
    """Measures distances at some configurations of a path, and tells which others need no look.

    Where the arm is measured, each pair of geoms has a distance. At another configuration it is
    smaller by no more than the way that a point of the one has come meanwhile, seen from the other.
    As long as more is left than is asked for, there is no contact.

    Most pairs are far enough apart by the spheres around them, of the others most by the boxes
    around them, and of the rest MuJoCo gives the distance. For arms that do more than turn about
    axes in a row nothing is proven.
    """

    def __init__(self, source: mujoco.MjModel, near: CollisionModel, joints: np.ndarray) -> None:
        """Prepare for a model.

        Args:
            source: What is simulated.
            near: Whose verdict it is that is foreseen here.
            joints: Ids of the arm's joints, from the base on.  # (nq,)
        """
        self._source, self._near, self._joints = source, near, joints
        self._scaled = scaled(source)
        self._unknown = distance_unknown(source)
        self._blind = True

    def watch(self, pairs: np.ndarray, part: np.ndarray | None) -> None:
        """Choose what is measured.

        Args:
            pairs: Pairs of geoms that shall not touch, and may.  # (ngeom, ngeom)
            part: By how many of the joints each geom is moved; None where these do more than turn
                about axes in a row.  # (ngeom,)
        """
        model = self._source
        if part is None or model.nflex or (pairs & self._unknown).any():
            self._blind = True
            return
        self._blind = False
        self._part = np.where(pairs.any(axis=1), part, 0)
        first, second = np.nonzero(np.triu(pairs))
        swap = self._part[first] > self._part[second]
        self._pairs = np.where(swap, (second, first), (first, second))  # (2, npair)
        self._sides = self._part[self._pairs]
        self._corner = np.where(self._scaled[first, second], CORNER, 1.0)
        self._geoms, seen = np.unique(self._pairs, return_inverse=True)
        self._seen = seen.reshape(2, -1)  # the pairs, by places in _geoms
        self._radii = model.geom_rbound[self._pairs].sum(axis=0)
        flat = model.geom_type[self._pairs] == _PLANE
        self._flat = np.flatnonzero(flat.any(axis=0))
        self._flat_side = flat[1, self._flat].astype(int)

    def take(self) -> None:
        """Take over how thick everything is."""
        self._motion: ArmMotion | None = None  # fingers and what they hold may be elsewhere
        self._thick: np.ndarray | None = None

    def proven(self, path: np.ndarray, needed: np.ndarray, carried: Carried) -> np.ndarray:
        """Tell which of many configurations are free, without any doubt.

        Args:
            path: Configurations [rad].  # (n, nq)
            needed: Distance of each pair of geoms that is asked for [m], -inf where none.
                # (ngeom, ngeom)
            carried: Where what is held goes.

        Returns:
            Where this is False, nothing is known.  # (n,)
        """
        n, nq = path.shape
        if self._blind or n <= WINDOWS[-1]:
            return np.zeros(n, dtype=bool)
        if self._thick is None:
            thick = margins(self._near.model)[tuple(self._pairs)]
            self._thick = thick - self._near.padding
        asked = needed[tuple(self._pairs)]
        asked = np.where(asked > 0.0, self._corner * asked, asked) + self._thick + DOUBT
        filled = np.concatenate([path, np.repeat(path[-1:], -n % WINDOWS[0], axis=0)])
        proven = np.zeros(len(filled), dtype=bool)
        worth = ~proven
        for size in WINDOWS:
            rows = np.flatnonzero((worth & ~proven).reshape(-1, size)[:, 0])
            if not len(rows):
                break
            free, near = self._windows(filled.reshape(-1, size, nq)[rows], asked, carried)
            proven.reshape(-1, size)[rows] = free[:, np.newaxis]
            worth.reshape(-1, size)[rows] = ~near[:, np.newaxis]
        return proven[:n]

    def _windows(
        self, windows: np.ndarray, asked: np.ndarray, carried: Carried
    ) -> tuple[np.ndarray, np.ndarray]:
        """Measure at the middles of windows.

        Args:
            windows: Configurations [rad].  # (m, size, nq)
            asked: Least distance of each pair [m].  # (npair,)
            carried: As for `proven`.

        Returns:
            Which windows are free, and in which of them the arm is too near to something already in
            the middle.  # (m,), (m,)
        """
        middles = windows[:, windows.shape[1] // 2]
        turned = windows - middles[:, np.newaxis]
        near, geoms = self._near, self._geoms
        data, motion = near.data, self._motion
        stands, positions, matrices = [], [], []
        for q in middles:
            near.put(q, carried(q))
            if motion is None:
                motion = self._motion = ArmMotion(near.model, data, self._joints, self._part)
            stands.append(motion.stand(data))
            positions.append(data.geom_xpos[geoms])
            matrices.append(data.geom_xmat[geoms])
        assert motion is not None
        m, nq = middles.shape
        ways = np.zeros((m, nq + 1, nq + 1))
        ways[:, 0, 1:] = motion.ways(motion.stands(stands), turned).max(axis=1)
        ways[:, 1:, 1:] = motion.ways_apart(np.abs(turned).max(axis=1))
        enough = asked + ways[:, self._sides[0], self._sides[1]]
        return self._measured(np.array(positions), np.array(matrices), asked, enough)

    def _measured(
        self, positions: np.ndarray, matrices: np.ndarray, asked: np.ndarray, enough: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Tell where all pairs are farther apart than is enough, and where one is too near.

        Args:
            positions: Of the geoms [m].  # (m, ngeom, 3)
            matrices: Their axes.  # (m, ngeom, 9)
            asked: Least distance of each pair [m].  # (npair,)
            enough: Distance that is enough [m].  # (m, npair)
        """
        free, near = np.ones(len(enough), dtype=bool), np.zeros(len(enough), dtype=bool)
        rows, columns = np.nonzero(self._near_by_spheres(positions, matrices, enough))
        bounds = self._boxes_apart(positions, matrices, rows, columns, enough[rows, columns])
        left = bounds - enough[rows, columns]
        model, data = self._near.model, self._near.data
        at, turned = data.geom_xpos, data.geom_xmat
        for i in np.argsort(left, kind="stable").tolist():
            if left[i] >= 0.0:
                break
            row, column = rows[i], columns[i]
            if not free[row]:
                continue
            for k, geom in zip(self._seen[:, column], self._pairs[:, column], strict=True):
                at[geom], turned[geom] = positions[row, k], matrices[row, k]
            pair = self._pairs[:, column]
            distance = mujoco.mj_geomDistance(
                model, data, pair[0], pair[1], enough[row, column], None
            )
            if distance < enough[row, column]:
                free[row], near[row] = False, distance < asked[column]
        return free, near

    def _near_by_spheres(
        self, positions: np.ndarray, matrices: np.ndarray, enough: np.ndarray
    ) -> np.ndarray:
        """Mark the pairs that the spheres around them do not show to be as far apart as is enough.

        Args:
            positions: As for `_measured`.
            matrices: As for `_measured`.
            enough: As for `_measured`.
        """  # (m, npair)
        first, second = self._seen
        reach = np.maximum(enough + self._radii, 0.0)
        square = np.einsum("mgi,mgi->mg", positions, positions)
        product = (positions @ np.swapaxes(positions, 1, 2))[:, first, second]
        close: np.ndarray = square[:, first] + square[:, second] - 2.0 * product < reach * reach
        for column, side in zip(self._flat.tolist(), self._flat_side.tolist(), strict=True):
            pair = self._seen[:, column]
            plane, other = pair[side], pair[1 - side]
            normal = matrices[:, plane, 2::3]
            height = np.einsum("mi,mi->m", positions[:, other] - positions[:, plane], normal)
            close[:, column] = height < reach[:, column]
        return close

    def _boxes_apart(
        self,
        positions: np.ndarray,
        matrices: np.ndarray,
        rows: np.ndarray,
        columns: np.ndarray,
        enough: np.ndarray,
    ) -> np.ndarray:
        """Give how far the boxes around pairs of geoms are apart at least [m].

        Args:
            positions: As for `_measured`.
            matrices: As for `_measured`.
            rows: Which configurations.  # (n,)
            columns: Which pairs.  # (n,)
            enough: Where it is more than that, it matters no more by how much [m].  # (n,)
        """  # (n,)
        aabb = self._source.geom_aabb
        sides = []
        for seen, geoms in zip(self._seen, self._pairs, strict=True):
            box = aabb[geoms[columns]]
            rotation = matrices[rows, seen[columns]].reshape(-1, 3, 3)
            centre = positions[rows, seen[columns]]
            centre = centre + (rotation @ box[:, :3, np.newaxis])[..., 0]
            sides.append(Boxes(centre, rotation, box[:, 3:]))
        bound = apart(sides[0], sides[1], enough)
        bound[np.isin(columns, self._flat)] = -np.inf
        return bound
