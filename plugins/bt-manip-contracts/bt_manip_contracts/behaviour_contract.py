"""Contract of behaviours: checks of their life cycle."""

import json
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bt_manip.bt import Condition, Node, NodeStatus, Traits, Tree
from bt_manip.exceptions import NodeError
from bt_manip.runner import Station
from bt_manip.testing import AT_REST, Situations, Trial

BEHAVIOUR_TIMEOUT = 20.0  # [s] simulated
_NO_SUCH_NAME = "nothing_is_called_so"
_HALTS = 6
_BRAKING_SLACK = 0.25  # [s]


@dataclass(frozen=True)
class Example:
    """Example of the use of a behaviour, for its contract.

    Attributes:
        ports: Values of its ports.
        start: Start situation.
        fails: Sets of port values with which it must fail.
        status: Expected result.
    """

    ports: Mapping[str, Any] = field(default_factory=dict)
    start: str = AT_REST
    fails: tuple[Mapping[str, Any], ...] = ()
    status: str = "SUCCESS"


@dataclass(frozen=True)
class BehaviourCase:
    """A behaviour with its example."""

    cls: type[Node]
    example: Example
    situations: Situations

    def trial(self, station: Station, **ports: Any) -> Trial:
        """Return a trial of a new behaviour."""
        return Trial(station, self.cls(**{**self.example.ports, **ports}))

    def start(self) -> Station:
        """Restore the example's situation."""
        return self.situations.reset(self.example.start)

    def ticks(self) -> int:
        """Return the number of ticks of a complete run."""
        trial = self.trial(self.start())
        self.finish(trial)
        return trial.history.tick

    def states(self, moments: Collection[int]) -> tuple[Trial, dict[int, str]]:
        """Tick up to the last of some numbers of ticks; return the trial and its states as JSON."""
        trial, states = self.trial(self.start()), {}
        for ticks in range(max(moments) + 1):
            if ticks in moments:
                states[ticks] = json.dumps([trial.tree.get_state(), trial.station.get_state()])
            if ticks < max(moments):
                trial.tick()
        return trial, states

    def restore(self, state: str) -> Trial:
        """Return a trial of a new behaviour in such a state."""
        tree_state, station_state = json.loads(state)
        station = self.start()
        station.set_state(station_state)
        trial = self.trial(station)
        trial.tree.set_state(tree_state)
        return trial

    def finish(self, trial: Trial) -> None:
        """Run to the end and check the result."""
        status = trial.until_done(BEHAVIOUR_TIMEOUT)
        assert status.name == self.example.status, (
            f"{self.cls.__name__} ended with {status.name}, its example says "
            f"{self.example.status}\n{trial.explain()}"
        )


def needs_no_robot_to_be_built(case: BehaviourCase) -> None:
    """Check that it can be constructed, added to a tree and halted without a cell."""
    node = case.cls(**case.example.ports)
    assert case.cls.summary(), f"{case.cls.__name__} has no documentation for the palette"
    tree = Tree(node, clock=lambda: 0.0)
    tree.halt()
    state = json.loads(json.dumps(tree.get_state()))
    tree.set_state(state)
    assert tree.get_state() == state


def setup_starts_nothing(case: BehaviourCase) -> None:
    """Check that ``setup`` does not change the state of the station."""
    station = case.start()
    before = station.get_state()
    trial = case.trial(station)
    trial.tree.setup(**station.infrastructure)
    assert station.get_state() == before, f"setup of {case.cls.__name__} changes the station"


def ends_as_it_should(case: BehaviourCase) -> None:
    """Check that its example ends as expected and as its traits say; a condition in one tick."""
    station = case.start()
    trial = case.trial(station)
    case.finish(trial)
    _check_traits(case, station)
    ticks = trial.history.tick
    assert ticks == 1 or not issubclass(case.cls, Condition), (
        f"{case.cls.__name__} is a Condition and takes {ticks} ticks; longer work needs an Action"
    )


def _check_traits(case: BehaviourCase, station: Station) -> None:
    """Check that a declared status and the state of the gripper are those of the example's end."""
    traits: Traits | None = getattr(case.cls, "traits", None)
    if traits is None:
        return
    name, status = case.cls.__name__, case.example.status
    assert NodeStatus[status] in traits.returns, f"{name} ended with {status}; its traits do not"
    gripper = station.robot.gripper
    if status != NodeStatus.SUCCESS.name or gripper is None:
        return
    for fact, holds in (("open", gripper.is_open), ("holding", bool(gripper.held))):
        declared = traits.leaves.get(fact)
        assert declared in (None, holds), f"{name} leaves {fact}: {holds}; its traits: {declared}"


def never_steps_the_physics(case: BehaviourCase) -> None:
    """Check that a tick takes no simulated time and does not change the state of the physics."""
    station = case.start()
    cell, trial = station.cell, case.trial(station)
    status = NodeStatus.RUNNING
    for tick in range(round(BEHAVIOUR_TIMEOUT / 0.010)):
        if status is not NodeStatus.RUNNING:
            return
        time, generation, before = cell.time, cell.generation, cell.state_bytes()
        status = trial.tree.tick()
        assert cell.time == time, (
            f"tick {tick + 1} of {case.cls.__name__} takes {cell.time - time:.3f} s of simulation"
        )
        if cell.generation == generation:
            assert cell.state_bytes() == before, (
                f"tick {tick + 1} of {case.cls.__name__} changes the state of the physics"
            )
        cell.step(10)
    raise AssertionError(f"{case.cls.__name__} still runs after {BEHAVIOUR_TIMEOUT:g} s")


def halts_in_every_state(case: BehaviourCase) -> None:
    """Check that arm and gripper stop after a halt before, during and after a run.

    The tree is then idle and can be ticked again.
    """
    whole = case.ticks()
    moments = {0, 1, whole - 1, whole, *(whole * i // _HALTS for i in range(_HALTS))}
    for ticks, state in case.states(moments)[1].items():
        trial = case.restore(state)
        station = trial.station
        trial.halt()
        where = f"{case.cls.__name__}, halted after {ticks} of {whole} ticks,"
        status = trial.tree.nodes[0].engine_status
        assert status is NodeStatus.IDLE, f"{where} is {status.name}"
        end = station.cell.time + _braking_time(station)
        while station.arm.moving and station.cell.time < end:
            station.cell.step()
        assert not station.arm.moving, f"{where} does not stop the arm\n{trial.explain()}"
        station.cell.step(200)
        gripper = station.robot.gripper
        assert gripper is None or not gripper.moving, f"{where} leaves the gripper moving"
        if trial.tree.tick() is NodeStatus.IDLE:
            raise AssertionError(f"{where} cannot be ticked again")
        trial.halt()


def gives_a_reason_when_it_fails(case: BehaviourCase) -> None:
    """Check that failures have a reason: for unknown names and for the example's failures."""
    wrong = [{name: _NO_SUCH_NAME} for name in _names(case)]
    for ports in wrong + [dict(ports) for ports in case.example.fails]:
        station = case.start()
        try:
            trial = case.trial(station, **ports)
        except NodeError:
            continue  # found before the run, with the node's path and a message
        try:
            status = trial.until_done(BEHAVIOUR_TIMEOUT)
        except NodeError as error:
            raise AssertionError(
                f"{case.cls.__name__} with {ports} raises instead of failing: "
                f"{error.__cause__ or error}; it may `return self.fail(str(error))`\n"
                + trial.explain()
            ) from error
        said = trial.behaviour.feedback_message.strip()
        if status is NodeStatus.FAILURE:
            assert said, f"{case.cls.__name__} with {ports} fails without a reason"
        elif ports not in wrong:
            raise AssertionError(
                f"{case.cls.__name__} with {ports} ended with {status.name}, expected FAILURE\n"
                + trial.explain()
            )


def runs_the_same_again(case: BehaviourCase) -> None:
    """Check that the same instance and a new one repeat a run bit for bit."""
    trial = case.trial(case.start())
    case.finish(trial)
    first = trial.history.tick, trial.station.cell.state_bytes()
    station = case.start()
    trial.history.tick = 0
    case.finish(trial)  # the same node again
    assert (trial.history.tick, station.cell.state_bytes()) == first, (
        f"{case.cls.__name__} keeps state of its first run"
    )
    another = case.trial(case.start())
    case.finish(another)
    assert (another.history.tick, station.cell.state_bytes()) == first, (
        f"two new instances of {case.cls.__name__} behave differently"
    )


def goes_on_from_its_state(case: BehaviourCase) -> None:
    """Check that another instance continues from its state, plain data, bit for bit."""
    whole = case.ticks()
    if whole == 1:
        return
    trial, states = case.states({1, whole // 2})
    case.finish(trial)
    ended = trial.station.cell.state_bytes()
    for ticks, state in states.items():
        another = case.restore(state)
        case.finish(another)
        assert another.station.cell.state_bytes() == ended, (
            f"{case.cls.__name__} continues differently from its state after {ticks} ticks"
        )


BEHAVIOUR_CONTRACT: tuple[Callable[[BehaviourCase], None], ...] = (
    needs_no_robot_to_be_built,
    setup_starts_nothing,
    ends_as_it_should,
    never_steps_the_physics,
    halts_in_every_state,
    gives_a_reason_when_it_fails,
    runs_the_same_again,
    goes_on_from_its_state,
)
"""Checks of the contract; each raises `AssertionError` if it fails."""


def _names(case: BehaviourCase) -> list[str]:
    """Return the ports of the example that contain a name: strings that are no blackboard keys."""
    return [
        name
        for name, value in case.example.ports.items()
        if isinstance(value, str) and case.cls.ports[name].type.name == "std::string"
        and not value.startswith("{")
    ]  # fmt: skip


def _braking_time(station: Station) -> float:
    """Return a generous stopping time: twice that of the slowest joint alone [s]."""
    limits, v = station.robot.limits, np.abs(station.arm.v)
    alone = v / limits.acceleration + 2.0 * limits.acceleration / limits.jerk
    return 2.0 * float(alone.max()) + _BRAKING_SLACK
