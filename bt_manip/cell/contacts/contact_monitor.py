"""A judgement of every step: does anything touch what it should not?"""

from collections.abc import Iterable
from typing import NamedTuple

import mujoco
import numpy as np

from ..naming import BodyNames, entity_of

# Different contact lists seen since the compile; a run of the reference task sees some hundreds.
_MOST_REMEMBERED = 4096


class ContactSummary(NamedTuple):
    """What the contacts of one step mean."""

    unexpected: tuple[tuple[str, str], ...]
    """Pairs of bodies where a robot touches something with anything but its fingers, or a robot."""
    held: tuple[str, ...]
    """Entities that fingers touch, robots apart."""
    free: bool
    """Neither fingers nor what they touch meet anything but each other."""


NOTHING = ContactSummary((), (), True)


class ContactMonitor:
    """Judges contacts in about a microsecond a step, by remembering judged contact lists.

    A robot is an entity with fingers. Nothing of it but the fingers may touch anything, and these
    may not touch another robot; things that are not robots may touch each other as they like.
    """

    def __init__(self, data: mujoco.MjData, labels: BodyNames, fingers: Iterable[str]):
        """Build the table for one compiled model.

        Args:
            data: Where the contacts stand.
            labels: Names of the geoms.
            fingers: Body names of all fingers, as ``entity/body``.
        """
        self._data = data
        # By number of contacts: MuJoCo keeps them at the beginning of its arena, where they are
        # looked at without being looked up, which takes longer than all the rest.
        self._pairs: dict[int, np.ndarray] = {}
        self._label = labels.of_geom
        self._fingers = frozenset(fingers)
        self._robots = frozenset(map(entity_of, self._fingers))
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
            if body in self._fingers and entity_of(other) not in self._robots
        }
        mine = {*self._fingers, *held}
        free = all(
            (self._mine(a, mine) == self._mine(b, mine)) for a, b in pairs
        )  # a pair of which one side is ours and the other is not breaks it
        return ContactSummary(tuple(sorted(unexpected)), tuple(sorted(held)), free)

    def _forbidden(self, body: str) -> bool:
        return entity_of(body) in self._robots and body not in self._fingers

    def _of_two_robots(self, first: str, second: str) -> bool:
        robots = {entity_of(first), entity_of(second)}
        return len(robots) > 1 and robots <= self._robots

    @staticmethod
    def _mine(body: str, mine: set[str]) -> bool:
        return body in mine or entity_of(body) in mine
