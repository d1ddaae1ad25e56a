"""Contacts, their forces and their events, by the names of bodies and entities."""

from typing import NamedTuple

import mujoco
import numpy as np

from bt_manip.exceptions import did_you_mean
from bt_manip.spatial import cross

from ..exceptions import CellError
from ..naming import BodyNames


class Wrench(NamedTuple):
    """A force and a torque about a point."""

    force: np.ndarray  # (3,) [N]
    torque: np.ndarray  # (3,) [N m]


class ContactForce(NamedTuple):
    """Contact force of one body on another."""

    normal: float  # [N] sum over the contact points, never negative
    friction: float  # [N] length of the sum of the tangential forces
    force: np.ndarray  # (3,) [N] on the second body, in the world frame


class ContactPoint(NamedTuple):
    """A contact point of a body or entity."""

    other: str
    """The other body."""
    position: np.ndarray  # (3,) [m] in the world
    normal: np.ndarray  # (3,) unit, from the other body to this one, in the world
    force: float  # [N] along the normal, never negative


class _Views(NamedTuple):
    """Views of MuJoCo's contacts."""

    geoms: np.ndarray  # (n, 2)
    addresses: np.ndarray  # (n,) of their constraints
    positions: np.ndarray  # (n, 3) [m]
    frames: np.ndarray  # (n, 3, 3) axes as rows


class Contacts:
    """The contacts of the last step, by the names of bodies and entities.

    A body is called ``entity/body``, or ``entity`` if the entity has one body; an entity's name
    refers to all its bodies. As after ``mj_step``, contacts and forces are those of the state at
    the start of the last step.

    Args:
        model: The compiled model; each compile needs a new object.
        data: Its data.
        body_names: Its names.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, body_names: BodyNames):
        self._model = model
        self._data = data
        self._body_names = body_names
        self._force = np.zeros(6)
        self._views: dict[int, _Views] = {}

    def fingerprint(self) -> bytes:
        """Return bytes that change whenever the set of active contacts changes, and seldom else."""
        view = self._view()
        return view.geoms.tobytes() + view.addresses.tobytes()

    def pairs(self) -> list[tuple[str, str]]:
        """Return the pairs of bodies in contact, sorted, without duplicates."""
        body = self._body_names.of_geom
        view = self._view()
        found = {
            (body[a], body[b]) if body[a] < body[b] else (body[b], body[a])
            for a, b in set(map(tuple, view.geoms[view.addresses >= 0].tolist()))
        }
        return sorted(found)

    def touching(self, name: str, other: str | None = None) -> bool:
        """Return whether a body or entity is in contact with another one, or with any other."""
        return bool(self._contacts_between(*self._sides(name, other)))

    def partners(self, name: str) -> list[str]:
        """Return the bodies of other entities in contact with a body or entity."""
        return sorted({point.other for point in self.points(name)})

    def points(self, name: str) -> list[ContactPoint]:
        """Return the contact points of a body or entity with other entities.

        Raises:
            CellError: If no body or entity has such a name.
        """
        mine, others = self._sides(name, None)
        body, found = self._body_names.of_geom, []
        geoms, positions = self._view().geoms, self._view().positions
        # The contact normal points from the first geom to the second.
        for index, sign in self._contacts_between(others, mine):
            normal = sign * self._contact_force(index)[0]
            force = float(self._force[0])
            other = body[geoms[index, 0 if sign > 0 else 1]]
            found.append(ContactPoint(other, positions[index].copy(), normal, force))
        return found

    def between(self, name: str, other: str) -> ContactForce:
        """Return the force of ``name`` on ``other``.

        Raises:
            CellError: If no body or entity has such a name.
        """
        first, second = self._sides(name, other)
        normal = 0.0
        tangential = np.zeros(3)
        total = np.zeros(3)
        for index, sign in self._contacts_between(first, second):
            frame = self._contact_force(index)
            normal += float(self._force[0])
            total += sign * (self._force[:3] @ frame)
            tangential += sign * (self._force[1:3] @ frame[1:])
        return ContactForce(normal, float(np.linalg.norm(tangential)), total)

    def wrench(self, name: str, *, point: np.ndarray | None = None) -> Wrench:
        """Return the sum of all external contact forces on a body or entity, in the world.

        Args:
            name: The body or entity.
            point: Reference point of the torque in the world [m]; default: the origin of the
                body.  # (3,)

        Raises:
            CellError: If no body or entity has such a name.
        """
        mine, others = self._sides(name, None)
        if point is None:
            point = self._data.xpos[self._body_names.body_ids(name)[0]]
        found, view = self._contacts_between(others, mine), self._view()
        local, force, torque = np.empty((len(found), 6)), np.zeros(3), np.zeros(3)
        for row, (index, _) in zip(local, found, strict=True):
            mujoco.mj_contactForce(self._model, self._data, index, row)
        indices = [index for index, _ in found]
        world = local.reshape(-1, 2, 3) @ view.frames[indices]
        # The contact force points from the first geom to the second.
        for (index, sign), (f, t) in zip(found, world, strict=True):
            force += sign * f
            torque += sign * (cross(view.positions[index] - point, f) + t)
        return Wrench(force, torque)

    def geoms(self, name: str) -> np.ndarray:
        """Mask the geoms of a body or entity.

        Raises:
            CellError: If no body or entity has such a name.
        """  # (ngeom,) bool
        try:
            return self._body_names.geoms(name)
        except KeyError:
            near = did_you_mean(name, self._body_names.names())
            raise CellError(f"no body or entity of this cell is called '{name}'{near}") from None

    def _view(self) -> _Views:
        """Return views of the contacts.

        They are cached by the number of contacts, since MuJoCo stores contacts at a fixed address:
        creating them takes longer than reading them.
        """
        n = self._data.ncon
        if n not in self._views:
            contact = self._data.contact
            self._views[n] = _Views(
                contact.geom, contact.efc_address, contact.pos, contact.frame.reshape(n, 3, 3)
            )
        return self._views[n]

    def _sides(self, name: str, other: str | None) -> tuple[np.ndarray, np.ndarray]:
        first = self.geoms(name)
        return first, (~first if other is None else self.geoms(other))

    def _contacts_between(self, first: np.ndarray, second: np.ndarray) -> list[tuple[int, float]]:
        """Return the contacts of two sets of geoms, with sign +1 if the first set comes first."""
        view, found = self._view(), []
        one, two = first.tobytes(), second.tobytes()
        for i, (a, b) in enumerate(view.geoms.tolist()):
            forth, back = one[a] and two[b], one[b] and two[a]
            if (forth or back) and view.addresses[i] >= 0:  # no constraint: inside the margin only
                found.append((i, 1.0 if forth else -1.0))
        return found

    def _contact_force(self, index: int) -> np.ndarray:
        """Read a contact's force and torque into the buffer; return its axes as rows."""  # (3, 3)
        mujoco.mj_contactForce(self._model, self._data, index, self._force)
        return self._view().frames[index]


class ContactEvent(NamedTuple):
    """Two bodies come into contact or lose contact."""

    time: float
    """Simulated time of the step [s]."""
    first: str
    second: str
    begins: bool


class ContactEventDetector:
    """Compares the pairs of bodies in contact with the previous update."""

    def __init__(self, contacts: Contacts):
        self._contacts = contacts
        self._pairs = set(contacts.pairs())
        self._key = contacts.fingerprint()

    def update(self, contacts: Contacts, time: float) -> list[ContactEvent]:
        """Return the events since the last update, sorted by name; ends first.

        Args:
            contacts: The present contacts, of the same or a later compile.
            time: The present time [s].
        """
        key = contacts.fingerprint()
        if key == self._key and contacts is self._contacts:  # a compile changes ids
            return []
        before, self._pairs = self._pairs, set(contacts.pairs())
        self._contacts, self._key = contacts, key
        ended = [ContactEvent(time, *pair, False) for pair in sorted(before - self._pairs)]
        return ended + [ContactEvent(time, *pair, True) for pair in sorted(self._pairs - before)]
