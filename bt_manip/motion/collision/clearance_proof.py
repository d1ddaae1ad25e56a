"""Prove configurations free that nobody looks at, by how far the arm is from what is nearby."""

from collections.abc import Callable

import mujoco
import numpy as np
import pinocchio as pin

from .arm_motion import ArmMotion, Stand, part_of_body
from .enclosing_boxes import Boxes, apart
from .geom_pairs import comparable, exact, margins
from .lookout import Lookout

WIDE = 0.05  # [m] how far away contacts are seen
WINDOWS = (24, 6)  # configurations around one that is looked at; the latter where the first fails
DOUBT = 2e-4  # [m] by which distances may be off
CORNER = float(np.sqrt(3.0))  # boxes that are corner to corner are nearer for MuJoCo, by up to that
_FULL = int(mujoco.mjtWarning.mjWARN_CONTACTFULL)
_PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)

Carried = Callable[[np.ndarray], pin.SE3 | None]
"""Gives the pose of what is held at a configuration; None where nothing is held."""


class ClearanceProof:
    """Looks at some configurations of a path, and tells which others need no look.

    Where the arm is looked at, each pair of geoms has a distance, or more than `WIDE`. At another
    configuration it is smaller by no more than the way that a point of the one has come meanwhile,
    seen from the other. As long as more is left than is asked for, there is no contact.

    Distances are MuJoCo's own where it has a closed form for them; of other pairs those of the
    boxes around their geoms. For arms that do more than turn about axes in a row nothing is proven.
    """

    def __init__(
        self, source: mujoco.MjModel, near: Lookout, qpos_adr: np.ndarray, dof_adr: np.ndarray
    ) -> None:
        """Copy a model.

        Args:
            source: What is simulated.
            near: Whose verdict it is that is foreseen here.
            qpos_adr: Where the arm's positions are.  # (nq,)
            dof_adr: Where its velocities are.  # (nq,)
        """
        self._source, self._near = source, near
        self._joints = source.dof_jntid[dof_adr]
        self._part_of_body = part_of_body(source, self._joints)
        self._lookout = Lookout(source, WIDE, qpos_adr)
        self._comparable, self._exact = comparable(source), exact(source)
        self._blind = True

    def watch(self, bodies: np.ndarray, held: int, counts: np.ndarray) -> None:
        """Choose what is looked at.

        Args:
            bodies: Mark what moves.  # (nbody,)
            held: Root body of what goes with the tool; 0 where nothing does.
            counts: Pairs of geoms that shall not touch.  # (ngeom, ngeom)
        """
        self._lookout.watch(bodies, held)
        model, part = self._source, self._part_of_body
        if part is None or model.nflex:
            return
        part = np.where(model.body_rootid == held, len(self._joints), part) if held else part
        pairs = counts & self._comparable
        self._part = np.where(pairs.any(axis=1), part[model.geom_bodyid], 0)
        apart = self._part[:, np.newaxis] != self._part
        first, second = np.nonzero(np.triu(pairs & apart & ~self._exact))
        swap = self._part[first] > self._part[second]
        self._boxed = np.where(swap, (second, first), (first, second))  # (2, npair)
        self._box_geoms, self._sides = np.unique(self._boxed, return_inverse=True)
        self._blind = bool((model.geom_type[self._box_geoms] == _PLANE).any())

    def take(self) -> None:
        """Take over where everything is, and how thick."""
        own, near = self._lookout.model, self._near.model
        more = 0.5 * (WIDE - self._near.padding)
        own.geom_margin[:] = near.geom_margin + more
        own.body_margin[:] = near.body_margin + more
        self._lookout.take(self._near.data)
        self._motion: ArmMotion | None = None  # fingers and what they hold may be elsewhere

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
        if self._blind or n <= WINDOWS[-1] or not self._kept(path[0], needed, carried):
            return np.zeros(n, dtype=bool)
        overflows = self._overflows
        filled = np.concatenate([path, np.repeat(path[-1:], -n % WINDOWS[0], axis=0)])
        proven = np.zeros(len(filled), dtype=bool)
        worth = ~proven
        for size in WINDOWS:
            rows = np.flatnonzero((worth & ~proven).reshape(-1, size)[:, 0])
            if not len(rows):
                break
            free, near = self._proven(filled.reshape(-1, size, nq)[rows], needed, carried)
            proven.reshape(-1, size)[rows] = free[:, np.newaxis]
            worth.reshape(-1, size)[rows] = ~near[:, np.newaxis]
        return proven[:n] & (self._overflows == overflows)

    def _kept(self, q: np.ndarray, needed: np.ndarray, carried: Carried) -> bool:
        """Tell whether geoms of the same part, which never move apart, are as far as asked for."""
        self._near.look(q, carried(q))
        first, second, distance = self._near.seen
        same = self._part[first] == self._part[second]
        return not (distance < needed[first, second])[same].any()

    def _proven(
        self, windows: np.ndarray, needed: np.ndarray, carried: Carried
    ) -> tuple[np.ndarray, np.ndarray]:
        """Look at the middles of windows.

        Args:
            windows: Configurations [rad].  # (m, size, nq)
            needed: As for `proven`.
            carried: As for `proven`.

        Returns:
            Which windows are free, and in which of them the arm is too near to something already in
            the middle.  # (m,), (m,)
        """
        middles = windows[:, windows.shape[1] // 2]
        turned = windows - middles[:, np.newaxis]
        left, stand, motion = self._look(middles, needed, carried)
        ways = motion.ways(stand, turned).max(axis=1)
        ways_apart = motion.ways_apart(np.abs(turned).max(axis=1))
        free = (ways <= left[:, 0, 1:]).all(axis=1)
        free &= (ways_apart <= left[:, 1:, 1:]).all(axis=(1, 2))
        return free, left.min(axis=(1, 2)) < 0.0

    def _look(
        self, configurations: np.ndarray, needed: np.ndarray, carried: Carried
    ) -> tuple[np.ndarray, Stand, ArmMotion]:
        """Give how much farther than asked for everything is at least from everything [m].

        Returns:
            By the parts on both sides, the one nearer to the base first; and where the arm stands
            in all this.  # (m, nq + 1, nq + 1)
        """
        lookout, part = self._lookout, self._part
        data, geoms = lookout.data, self._box_geoms
        motion = self._motion
        parts, most = len(self._joints) + 1, max(float(needed.max()), 0.0)
        left = np.full((len(configurations), parts, parts), WIDE - DOUBT - most)
        stands, positions, matrices, seen = [], [], [], []
        for q in configurations:
            lookout.look(q, carried(q))
            if motion is None:
                motion = self._motion = ArmMotion(lookout.model, data, self._joints, part)
                self._box_margins = margins(lookout.model)[tuple(self._boxed)] - WIDE
            stands.append(motion.stand(data))
            positions.append(data.geom_xpos[geoms])
            matrices.append(data.geom_xmat[geoms])
            seen.append(lookout.seen)
        assert motion is not None
        rows = np.repeat(np.arange(len(seen)), [len(distance) for *_, distance in seen])
        first, second, distance = map(np.concatenate, zip(*seen, strict=True))
        known = self._exact[first, second] & (part[first] != part[second])
        first, second = first[known], second[known]
        slack = distance[known] - needed[first, second] - DOUBT
        one, other = part[first], part[second]
        sides = rows[known], np.minimum(one, other), np.maximum(one, other)
        np.minimum.at(left, sides, slack)
        if len(geoms):
            self._look_at_boxes(np.array(positions), np.array(matrices), needed, left)
        return left, motion.stands(stands), motion

    def _look_at_boxes(
        self, positions: np.ndarray, matrices: np.ndarray, needed: np.ndarray, left: np.ndarray
    ) -> None:
        """Take into account the pairs of which only the boxes around them are compared."""
        aabb = self._source.geom_aabb[self._box_geoms]
        rotation = matrices.reshape(*positions.shape, 3)
        centre = positions + (rotation @ aabb[:, :3, np.newaxis])[..., 0]
        half = np.broadcast_to(aabb[:, 3:], centre.shape)
        one, other = (
            Boxes(
                centre[:, side].reshape(-1, 3),
                rotation[:, side].reshape(-1, 3, 3),
                half[:, side].reshape(-1, 3),
            )
            for side in self._sides.reshape(2, -1)
        )
        asked = needed[tuple(self._boxed)]
        asked = np.where(asked > 0.0, CORNER * asked, asked) + self._box_margins + DOUBT
        enough = float(left.max() + asked.max())
        slack = apart(one, other, enough).reshape(len(left), -1) - asked
        rows = np.arange(len(left))[:, np.newaxis]
        first, second = self._part[self._boxed]
        np.minimum.at(left, (rows, first, second), slack)

    @property
    def _overflows(self) -> int:
        """How often there was no room for a contact."""
        return int(self._lookout.data.warning.number[_FULL])
