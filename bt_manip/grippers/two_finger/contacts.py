"""Contacts of the fingers: forces and touched entities."""

from collections.abc import Sequence
from functools import lru_cache

import mujoco
import numpy as np
from dm_control import mjcf

from bt_manip.cell import BodyNames, entity_of

from .mechanism import Mechanism

_CACHED = 256  # cached lists of contacts; they recur while an object is held
_REACH = 0.3  # [m] radius of the sensor zones, large enough for all contacts of a finger

Touched = tuple[tuple[str, ...], tuple[str, ...]]
"""Names of the entities that touch the first and the second finger."""


class FingerContacts:
    """Touch sensors in a robot's two fingers, and the names of the entities that they touch.

    A touch sensor sums the normal forces of its body's contacts inside MuJoCo, which saves a loop
    over contacts in Python.

    Args:
        root: The robot's model, to which the sensors are added; not compiled yet.
        mechanism: The gripper's mechanism.
    """

    def __init__(self, root: mjcf.RootElement, mechanism: Mechanism):
        self._mechanism = mechanism
        self._sensors = []
        for finger in mechanism.fingers:
            name = f"{finger.name}_touch"
            # Group 5 is hidden in all viewers by default.
            site = finger.add(
                "site", name=name, type="sphere", size=(_REACH,), group=5, rgba=(0, 0, 0, 0)
            )
            self._sensors.append(root.sensor.add("touch", name=name, site=site))

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Bind to a compiled model."""
        left, right = (model.sensor(s.full_identifier).adr[0] for s in self._sensors)
        self._bound = data.sensordata.item, int(left), int(right)
        self._geoms = self._mechanism.geoms
        self._model, self._data = model, data
        self._labels: BodyNames | None = None
        self._touched = lru_cache(_CACHED)(self._touched_by)

    def forces(self) -> tuple[float, float]:
        """Return the normal force on each finger [N]."""
        force, left, right = self._bound
        return force(left), force(right)

    def names(self) -> Touched:
        """Return the names of the entities that touch each finger, excluding the robot."""
        return self._touched(self._data.contact.geom.tobytes())

    def _touched_by(self, contacts: bytes) -> Touched:
        """Return the names of the touched entities for pairs of geoms in contact."""
        pairs = np.frombuffer(contacts, np.int32).reshape(-1, 2).tolist()
        left, right = (self._partners(geoms, pairs) for geoms in self._geoms)
        return left, right

    def _partners(self, geoms: tuple[int, ...], pairs: list[list[int]]) -> tuple[str, ...]:
        if self._labels is None:
            self._labels = BodyNames(self._model)
        label = self._labels.of_geom
        own = entity_of(label[geoms[0]])
        found = set()
        for a, b in pairs:
            for mine, other in ((a, b), (b, a)):
                if mine in geoms and entity_of(label[other]) != own:
                    found.add(entity_of(label[other]))
        return tuple(sorted(found))


def held_root(model: mujoco.MjModel, data: mujoco.MjData, fingers: Sequence[int]) -> int:
    """Return the root body of the free object that all fingers touch; 0 for none.

    Args:
        model: The compiled model.
        data: Its data, with current contacts.
        fingers: Ids of the finger bodies.
    """
    if not fingers or not data.ncon:
        return 0
    bodies = model.geom_bodyid[data.contact.geom]  # (ncon, 2)
    roots: set[int] | None = None
    for finger in fingers:
        touched = bodies[:, ::-1][bodies == finger]
        here = {int(root) for root in model.body_rootid[touched]}
        roots = here if roots is None else roots & here
    return next((root for root in sorted(roots or ()) if model.body_dofnum[root] == 6), 0)
