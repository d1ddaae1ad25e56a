"""One small station for all tests of behaviours, put back to its start before each."""

from collections.abc import Callable

import pytest
from py_trees.behaviour import Behaviour

from bt_manip import spatial
from bt_manip.bt import NodeStatus, Tree
from bt_manip.runner.station import Station, build_station

TICK = 10  # control steps


class Trial:
    """One behaviour in a station, ticked by hand."""

    def __init__(self, station: Station, behaviour: Behaviour) -> None:
        self.station, self.behaviour = station, behaviour
        self.tree = Tree(behaviour, clock=lambda: station.cell.time)
        self.tree.setup(**station.infrastructure)

    def tick(self) -> NodeStatus:
        """Tick once and let a tick's time pass."""
        status = self.tree.tick()
        self.station.cell.step(TICK)
        return status

    def until_done(self, timeout: float = 3.0) -> NodeStatus:
        """Tick until the behaviour ends, for at most some simulated time [s]."""
        end = self.station.cell.time + timeout
        status = self.tick()
        while status is NodeStatus.RUNNING and self.station.cell.time < end:
            status = self.tick()
        return status

    def fails_with(self, *words: str, timeout: float = 3.0) -> bool:
        """Run it; tell whether it fails for a reason that has these words."""
        failed = self.until_done(timeout) is NodeStatus.FAILURE
        return failed and all(word in self.behaviour.feedback_message for word in words)


@pytest.fixture(scope="session")
def built() -> Station:
    station = build_station(seed=0)
    cube = station.models.create("cube")
    station.cell.add(cube, spatial.pose((0.3, 0.1, 1.015 + cube.rest_height)), name="cube")
    station.cell.step(100)
    return station


@pytest.fixture(scope="session")
def at_rest(built: Station) -> dict:
    """The arm at home, the gripper open, a cube on the table."""
    return built.get_state()


@pytest.fixture(scope="session")
def around_the_cube(built: Station, at_rest: dict) -> dict:
    """The open fingers around the cube."""
    built.set_state(at_rest)
    from bt_manip.behaviours import Hover, Reach

    for behaviour in (Hover(object="cube", height=0.15), Reach(object="cube")):
        assert Trial(built, behaviour).until_done() is NodeStatus.SUCCESS
    return built.get_state()


@pytest.fixture(scope="session")
def holding(built: Station, around_the_cube: dict) -> dict:
    """The cube between the fingers, over the table."""
    built.set_state(around_the_cube)
    from bt_manip.behaviours import Grasp, Lift

    for behaviour in (Grasp(object="cube"), Lift(height=0.15)):
        assert Trial(built, behaviour).until_done() is NodeStatus.SUCCESS
    return built.get_state()


@pytest.fixture
def station(built: Station, at_rest: dict) -> Station:
    built.set_state(at_rest)
    return built


@pytest.fixture
def trial(station: Station) -> Callable[[Behaviour], Trial]:
    return lambda behaviour: Trial(station, behaviour)
