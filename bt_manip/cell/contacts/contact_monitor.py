"""Classification of each step's contacts: held objects and unexpected contacts of robots."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import mujoco
import numpy as np
from dm_control import composer, mjcf

from ..naming import BodyNames, body_name, entity_of

_MAX_CACHED = 4096
"""Number of cached lists of contacts; a run of pick_place has some hundreds."""


class MonitoredEntity(composer.Entity):
    """A robot: an entity of which only some bodies may have contacts."""

    @property
    def contact_bodies(self) -> Sequence[mjcf.Element]:
        """Bodies of the gripper, which may touch objects."""
        return ()


class ContactSummary(NamedTuple):
    """Classification of one step's contacts."""

    unexpected: tuple[tuple[str, str], ...]
    """Pairs of bodies of two robots, or with a robot's body that may not have contacts."""
    held: tuple[str, ...]
    """Entities in contact with grippers, robots excluded."""
    free: bool
    """Whether grippers and held entities touch only each other."""


NO_CONTACTS = ContactSummary((), (), True)


class ContactMonitor:
    """Classifies contacts in about 1 us per step, by caching the summaries of contact lists.

    Only the contact bodies of a robot's gripper may touch other entities, but no other robot.
    Contacts without a robot are always allowed.

    Args:
        data: Data of the compiled model.
        body_names: Names of its bodies.
        entities: All entities in the arena.
    """

    def __init__(
        self, data: mujoco.MjData, body_names: BodyNames, entities: Iterable[composer.Entity]
    ):
        self._data = data
        # Views of the contacts' geoms by number of contacts, which MuJoCo stores at a fixed
        # address: `data.contact.geom` takes longer than the rest of this method.
        self._pairs: dict[int, np.ndarray] = {}
        self._names = body_names.of_geom
        robots = [entity for entity in entities if isinstance(entity, MonitoredEntity)]
        self._robots = frozenset(entity_of(robot.mjcf_model.full_identifier) for robot in robots)
        self._contact_bodies = frozenset(
            body_name(body.full_identifier) for robot in robots for body in robot.contact_bodies
        )
        self._cached: dict[bytes, ContactSummary] = {b"": NO_CONTACTS}

    def summary(self) -> ContactSummary:
        """Return the summary of the last step's contacts."""
        n = self._data.ncon
        pairs = self._pairs.get(n)
        if pairs is None:
            pairs = self._pairs[n] = self._data.contact.geom
        key = pairs.tobytes()
        summary = self._cached.get(key)
        if summary is None:
            if len(self._cached) >= _MAX_CACHED:
                self._cached.clear()
            summary = self._cached[key] = self._classify(pairs.tolist())
        return summary

    def _classify(self, geoms: list[list[int]]) -> ContactSummary:
        names = self._names
        pairs = {(names[a], names[b]) for a, b in geoms}
        unexpected = {(min(pair), max(pair)) for pair in pairs if self._is_unexpected(*pair)}
        held = {
            entity_of(other)
            for pair in pairs
            for body, other in (pair, pair[::-1])
            if body in self._contact_bodies and entity_of(other) not in self._robots
        }
        gripped = {*self._contact_bodies, *held}
        inside = [[b in gripped or entity_of(b) in gripped for b in pair] for pair in pairs]
        free = all(first == second for first, second in inside)
        return ContactSummary(tuple(sorted(unexpected)), tuple(sorted(held)), free)

    def _is_unexpected(self, *bodies: str) -> bool:
        robots = {entity_of(body) for body in bodies} & self._robots
        two_robots = len(robots) > 1
        return two_robots or any(
            entity_of(body) in robots and body not in self._contact_bodies for body in bodies
        )
