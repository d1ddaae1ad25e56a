"""Start situations of tests, each simulated once per session."""

from collections.abc import Callable
from typing import Any

from py_trees.behaviour import Behaviour

from bt_manip import spatial
from bt_manip.behaviours import Grasp, Hover, Lift, Reach
from bt_manip.bt import NodeStatus
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.runner import Station

AT_REST = "at rest"
AROUND_THE_CUBE = "around the cube"
HOLDING = "holding a cube over the table"

Make = Callable[[Station], object]
"""Function that changes a station from one situation to another."""


class Situations:
    """Start situations by name, as snapshots of one station.

    A situation is simulated on its first use, starting from the one that it follows, and kept as a
    snapshot. Restoring it takes less than a millisecond, a few milliseconds after a test that
    added objects, and the time of a compile after a test that removed objects of the situation.
    """

    def __init__(self, build: Callable[[], Station]) -> None:
        self._build = build
        self._station: Station | None = None
        self._makers: dict[str, tuple[Make, str | None]] = {}
        self._snapshots: dict[str | None, dict[str, Any]] = {}

    def add(self, name: str, make: Make, *, after: str | None = AT_REST) -> None:
        """Add a situation.

        Args:
            name: Its name in tests.
            make: Called with the station to create the situation, for example with `play`.
            after: The situation before; None for the station as built.

        Raises:
            BtManipError: When another situation has the name, or the one before is unknown.
        """
        if name in self._makers:
            known, follows = self._makers[name]
            if (_code(known), follows) != (_code(make), after):
                raise BtManipError(f"there is already a situation '{name}'")
            return
        if after is not None and after not in self._makers:
            raise self._unknown(after)
        self._makers[name] = (make, after)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all situations."""
        return tuple(self._makers)

    def reset(self, name: str = AT_REST) -> Station:
        """Return the station, restored to a situation.

        Raises:
            BtManipError: When it is unknown.
        """
        if self._station is None:
            self._station = self._build()
            self._snapshots[None] = self._station.get_state()
        station = self._station
        snapshot = self._snapshots.get(name)
        if snapshot is not None:
            station.set_state(snapshot)
            return station
        if name not in self._makers:
            raise self._unknown(name)
        make, after = self._makers[name]
        if after is None:
            station.set_state(self._snapshots[None])
        else:
            self.reset(after)
        make(station)
        self._snapshots[name] = station.get_state()
        return station

    def _unknown(self, name: str) -> BtManipError:
        return BtManipError(f"no start situation '{name}'{did_you_mean(name, self._makers)}")


def _code(make: Make) -> object:
    """Return a key that is equal for all functions created by the same definition."""
    return getattr(make, "__code__", make)


def play(station: Station, *behaviours: Behaviour, timeout: float = 10.0) -> None:
    """Run behaviours one after another, each to success.

    Args:
        station: The station.
        *behaviours: The behaviours.
        timeout: Longest simulated time for each [s].

    Raises:
        AssertionError: When one does not succeed, with the reason.
    """
    for behaviour in behaviours:
        result = station.run(behaviour, timeout=timeout)
        if result.status is not NodeStatus.SUCCESS:
            raise AssertionError(f"{behaviour.name} ended with {result}")


def built_in_situations(build: Callable[[], Station]) -> Situations:
    """Return the built-in situations: a cube on the table, in reach, and held.

    Args:
        build: Builds a station with a table whose surface is 1.015 m above the floor. A ``cube``
            of its scene stays where it is.
    """
    situations = Situations(build)
    situations.add(AT_REST, _put_a_cube_on_the_table, after=None)
    situations.add(
        AROUND_THE_CUBE,
        lambda station: play(station, Hover(object="cube", height=0.15), Reach(object="cube")),
    )
    situations.add(
        HOLDING,
        lambda station: play(station, Grasp(object="cube"), Lift(height=0.15)),
        after=AROUND_THE_CUBE,
    )
    return situations


def _put_a_cube_on_the_table(station: Station) -> None:
    if "cube" not in station.cell.entities:  # else that of the scene
        cube = station.models.create("cube")
        table = station.cell.entities["table"]
        height = station.cell.pose("table").translation[2] + table.surface_height
        station.cell.add(cube, spatial.pose((0.3, 0.1, height + cube.rest_height)), name="cube")
    station.cell.step(100)
