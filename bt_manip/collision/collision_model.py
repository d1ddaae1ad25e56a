"""Where contacts are looked for, away from the physics."""

import mujoco
import numpy as np
import pinocchio as pin

from .scratch_model import restrict_pairs, scratch_model


class CollisionModel:
    """A private copy of the compiled model, in which the arm is put anywhere.

    MuJoCo's own collision detection answers: whatever the physics takes for a contact is one here,
    for every kind of geom and with the model's exclusions.

    Attributes:
        model: The copy.
        data: Its data.
        padding: How far away contacts are seen, beyond the model's own margins [m].
    """

    def __init__(self, source: mujoco.MjModel, padding: float, qpos_adr: np.ndarray) -> None:
        """Copy a model.

        Args:
            source: What is simulated.
            padding: How far away contacts are seen [m].
            qpos_adr: Where the arm's positions are.  # (nq,)
        """
        self._source, self.padding, self._adr = source, padding, qpos_adr
        self.model = scratch_model(source, padding)
        self.data = mujoco.MjData(self.model)
        self.watch(np.zeros((source.ngeom, source.ngeom), dtype=bool))

    def watch(self, pairs: np.ndarray, held: int = 0) -> None:
        """Choose what is looked at.

        Args:
            pairs: Pairs of geoms.  # (ngeom, ngeom)
            held: Root body of what goes with the tool; 0 where nothing does.
        """
        restrict_pairs(self.model, pairs)
        start = int(self.model.jnt_qposadr[self.model.body_jntadr[held]]) if held else 0
        qpos = self.data.qpos
        self._held_pos, self._held_quat = qpos[start : start + 3], qpos[start + 3 : start + 7]

    def widen(self, bodies: np.ndarray, by: float) -> None:
        """Take some bodies for thicker than they are.

        Args:
            bodies: Mark them.  # (nbody,)
            by: How much [m].
        """
        own, source = self.model, self._source
        more = 0.5 * self.padding
        own.geom_margin[:] = source.geom_margin + more + by * bodies[source.geom_bodyid]
        own.body_margin[:] = source.body_margin + more + by * bodies

    def take(self, data: mujoco.MjData) -> None:
        """Take over where everything is."""
        self.data.qpos[:] = data.qpos
        self.data.mocap_pos[:] = data.mocap_pos
        self.data.mocap_quat[:] = data.mocap_quat

    def look(self, q: np.ndarray, T_wo: pin.SE3 | None = None) -> int:
        """Put the arm at a configuration and find what is near.

        Args:
            q: Positions of the arm's joints [rad].  # (nq,)
            T_wo: Where what is held is then.

        Returns:
            How many contacts were seen; `seen` has them.
        """
        self.put(q, T_wo)
        mujoco.mj_collision(self.model, self.data)
        return int(self.data.ncon)

    def put(self, q: np.ndarray, T_wo: pin.SE3 | None = None) -> None:
        """Put the arm at a configuration.

        Args:
            q: Positions of the arm's joints [rad].  # (nq,)
            T_wo: Where what is held is then.
        """
        self.data.qpos[self._adr] = q
        if T_wo is not None:
            self._held_pos[:] = T_wo.translation
            mujoco.mju_mat2Quat(self._held_quat, T_wo.rotation.ravel())
        mujoco.mj_kinematics(self.model, self.data)

    @property
    def seen(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Geoms on both sides of each contact last seen, and their distance [m]."""
        contact = self.data.contact
        geoms = contact.geom.copy()
        # Less than what the model has for a margin: the physics pushes from there on.
        distance = contact.dist - contact.includemargin + self.padding
        return geoms[:, 0], geoms[:, 1], distance
