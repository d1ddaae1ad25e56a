"""A judgement of every step: does anything touch what it should not?"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import mujoco
import numpy as np

from ..naming import BodyNames, entity_of

# Different contact lists seen since the compile; a run of the reference task sees some hundreds.
_MOST_REMEMBERED = 4096


class ContactSummary(NamedTuple):
    """What the contacts of one step mean."""

    unexpected: tuple[tuple[str, str], ...]
    """Pairs of bodies where a robot touches something with another body than those of its gripper
    that may, or touches another robot."""
    held: tuple[str, ...]
    """Entities that grippers touch, robots apart."""
    free: bool
    """Neither grippers nor what they touch meet anything but each other."""


NOTHING = ContactSummary((), (), True)


class ContactMonitor:
    """Judges contacts in about a microsecond a step, by remembering judged contact lists.

    Nothing of a robot but the contact bodies of its gripper may touch anything, and these may not
    touch another robot; things that are not robots may touch each other as they like.
    """

    def __init__(self, data: mujoco.MjData, labels: BodyNames, robots: Mapping[str, Iterable[str]]):
        """Build the table for one compiled model.

        Args:
            data: Where the contacts stand.
            labels: Names of the geoms.
            robots: The bodies of each robot that may touch things, as ``entity/body``; by the
                names of the robots.
        """
        self._data = data
        # By number of contacts: MuJoCo keeps them at the beginning of its arena, where they are
        # looked at without being looked up, which takes longer than all the rest.
        self._pairs: dict[int, np.ndarray] = {}
        self._label = labels.of_geom
        self._contact_bodies = frozenset(body for bodies in robots.values() for body in bodies)
        self._robots = frozenset(robots)
        self._seen: dict[bytes, ContactSummary] = {b"": NOTHING}

    def summary(self) -> ContactSummary:
        """Judge the contacts of the last step."""
        n = self._data.ncon
        pairs = self._pairs.get(n)
        if pairs is None:
            pairs = self._pairs[n] = self._data.contact.geom
        key = pairs.tobytes()
        touch = self._seen.get(key)
        if touch is None:
            if len(self._seen) >= _MOST_REMEMBERED:
                self._seen.clear()
            touch = self._seen[key] = self._judge(pairs.tolist())
        return touch

    def _judge(self, geoms: list[list[int]]) -> ContactSummary:
        label = self._label
        pairs = {(label[a], label[b]) for a, b in geoms}
        unexpected = {
            (min(pair), max(pair))
            for pair in pairs
            if any(self._forbidden(b) for b in pair) or self._of_two_robots(*pair)
        }
        held = {
            entity_of(other)
            for pair in pairs
            for body, other in (pair, pair[::-1])
            if body in self._contact_bodies and entity_of(other) not in self._robots
        }
        mine = {*self._contact_bodies, *held}
        free = all(
            (self._mine(a, mine) == self._mine(b, mine)) for a, b in pairs
        )  # a pair of which one side is ours and the other is not breaks it
        return ContactSummary(tuple(sorted(unexpected)), tuple(sorted(held)), free)

    def _forbidden(self, body: str) -> bool:
        return entity_of(body) in self._robots and body not in self._contact_bodies

    def _of_two_robots(self, first: str, second: str) -> bool:
        robots = {entity_of(first), entity_of(second)}
        return len(robots) > 1 and robots <= self._robots

    @staticmethod
    def _mine(body: str, mine: set[str]) -> bool:
        return body in mine or entity_of(body) in mine
