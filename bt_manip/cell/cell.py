"""The cell: an arena whose entities come and go while the physics runs."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip.cell.altered_contents import AlteredContents
from bt_manip.cell.contacts.contact_events import ContactEvent, ContactEventDetector
from bt_manip.cell.contacts.contact_monitor import ContactMonitor
from bt_manip.cell.contacts.contacts import Contacts
from bt_manip.cell.exceptions import CellError
from bt_manip.cell.physics.attachment import Factory
from bt_manip.cell.physics.state import integration_state
from bt_manip.exceptions import did_you_mean
from bt_manip.spatial import pose as make_pose


class Cell(AlteredContents):
    """Owns the arena and its compiled physics, and is the one loop that steps it.

    Entities live by composer's hooks: ``after_compile`` runs for all of them after every change,
    ``initialize_episode`` once for each that is new, ``before_substep`` and ``after_substep``
    around each step, in the order in which ``composer.Environment`` runs them.
    """

    def __init__(
        self,
        arena: composer.Arena | None = None,
        timestep: float = 1e-3,
        random_state: np.random.RandomState | None = None,
    ):
        """Make a cell with nothing in it, or with what the arena already holds.

        Args:
            arena: The room; default: the project's own.
            timestep: Step of the physics [s].
            random_state: What composer's hooks get to draw from; default: seed 0.
        """
        super().__init__(arena, timestep, random_state)
        self.contact_changed: list[Callable[[ContactEvent], None]] = []
        """Called after each step with every contact that begins or ends; costs nothing if empty."""
        self._changes: ContactEventDetector | None = None

    # How it moves

    def step(self, n: int = 1, *, then: Sequence[Callable[[], None]] = ()) -> None:
        """Make ``n`` control steps: the entities' hooks around each step of the physics.

        Args:
            n: How many; many at once cost a little less than one by one.
            then: Called after each.

        Raises:
            PhysicsDiverged: When MuJoCo warns, as it does of numbers that are not finite.
        """
        if not self.contact_changed:
            self._changes = None
            self._compiled.step(n, self.random_state, then)
            return
        changes = self._changes = self._changes or ContactEventDetector(self.contacts)
        for _ in range(n):
            self._compiled.step(1, self.random_state)
            for event in changes.look(self.contacts, self.time):
                for listener in tuple(self.contact_changed):
                    listener(event)
            for look in then:
                look()

    @property
    def physics(self) -> mjcf.Physics:
        """The compiled physics; a change of the cell makes a new one."""
        return self._compiled.physics

    @property
    def model(self) -> mujoco.MjModel:
        """MuJoCo's own model, with what has been altered; the one that is simulated."""
        return self._compiled.model

    @property
    def data(self) -> mujoco.MjData:
        """MuJoCo's own data."""
        return self._compiled.data

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._compiled.data.time

    @property
    def dt(self) -> float:
        """Duration of a step [s]."""
        return self._compiled.model.opt.timestep

    # Where things are, and what touches what

    def pose(self, name: str) -> pin.SE3:
        """Give the pose of an entity's root in the world, ``T_we``.

        Raises:
            CellError: When there is none of that name.
        """
        placement = self._inventory.find(name)
        if not placement.free or name not in self._compiled.free_joints:
            return placement.pose
        qpos, _ = self._compiled.free_joints[name]
        q = self.data.qpos[qpos : qpos + 7]
        return make_pose(q[:3], q[3:])

    def velocity(self, name: str) -> np.ndarray:
        """Give the velocity of an entity's root: linear, then angular, both in the world.

        Raises:
            CellError: When there is none of that name.
        """  # (6,) [m/s, rad/s]
        if not self._inventory.find(name).free or name not in self._compiled.free_joints:
            return np.zeros(6)
        _, dof = self._compiled.free_joints[name]
        v = self.data.qvel[dof : dof + 6].copy()
        v[3:] = self.pose(name).rotation @ v[3:]  # a free joint's angular part is local
        return v

    def body_id(self, name: str) -> int:
        """Give the id of the root body of an entity, or of a body called ``entity/body``.

        Raises:
            CellError: When nothing is called so.
        """
        labels = self._compiled.labels
        try:
            return labels.body_ids(name)[0]
        except KeyError:
            raise CellError(
                f"no body or entity is called '{name}'{did_you_mean(name, labels.names())}"
            ) from None

    @property
    def contacts(self) -> Contacts:
        """The contacts of the last step."""
        return self._compiled.contacts

    @property
    def contact_monitor(self) -> ContactMonitor:
        """The judge of each step's contacts."""
        return self._compiled.contact_monitor

    # Its state

    def state_bytes(self) -> bytes:
        """Give MuJoCo's integration state as bytes, for digests and comparisons."""
        return integration_state(self.model, self.data).tobytes()

    def snapshot(self) -> dict[str, Any]:
        """Give all that the cell's future follows from, as plain data.

        The integration state, what stands in the cell with the states of those objects that have
        one, what is altered, and what composer's hooks draw from. Robots and controllers give
        theirs by themselves.
        """
        before = self._compiled.before_last_step()
        algorithm, keys, *rest = self.random_state.get_state()
        return {
            "entities": [p.describe(name) for name, p in self._inventory.placed.items()],
            "altered": self._assembly.overrides.get_state(),
            "states": {
                n: e.get_state() for n, e in self.objects.items() if hasattr(e, "get_state")
            },
            "integration": integration_state(self.model, self.data).tolist(),
            "before": None if before is None else before.tolist(),
            "random_state": [algorithm, np.asarray(keys).tolist(), *rest],
        }

    def restore(self, snapshot: Mapping[str, Any], factory: Factory | None = None) -> None:
        """Come back to a moment, taking out and putting in entities where that is needed.

        What already stands at its place in the order, alike in name and kind, stays what it is.

        Args:
            snapshot: What ``snapshot`` gave.
            factory: Makes the entity of an entry of ``snapshot["entities"]``; needed where the
                cell lacks one.

        Raises:
            CellError: When an entity is missing and cannot be made, or the numbers do not fit;
                the cell is unchanged but for entities that came and went.
        """
        self._become(snapshot["entities"], snapshot["altered"], factory)
        before = snapshot["before"]
        try:
            self._compiled.restore(
                np.array(snapshot["integration"]), None if before is None else np.array(before)
            )
        except ValueError as error:
            raise CellError(f"the snapshot does not fit this cell: {error}") from error
        for name, kept in snapshot["states"].items():
            self.objects[name].set_state(kept)
        self.random_state.set_state(tuple(snapshot["random_state"]))
