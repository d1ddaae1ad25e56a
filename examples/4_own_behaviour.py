"""A new behaviour, which weighs the held object, and its unit tests.

Run the tests: pytest examples/4_own_behaviour.py
"""

from typing import Any

import pytest

from bt_manip import build_station
from bt_manip.behaviours import Grasp, Hover, IsHolding, Lift, Reach
from bt_manip.bt import Action, Input, NodeStatus, Output, Sequence, Status, Tree
from bt_manip.cell import Cell
from bt_manip.cell.objects import Cube
from bt_manip.robots import Gripper
from bt_manip.runner import Station
from bt_manip.spatial import pose

GRAVITY = 9.81  # [m/s2]


class Weigh(Action):
    """Weigh a held object by the contact force of the fingers."""

    object = Input(str, doc="Name of the object.")
    duration = Input(float, default=0.2, doc="Simulated time to average over [s].")
    mass = Output(float, doc="Mass of the object [kg].")

    def setup(self, *, cell: Cell, gripper: Gripper, **_: Any) -> None:
        """Store cell and gripper; trees can be built, drawn and checked without them."""
        self.cell, self.gripper = cell, gripper

    def initialise(self) -> None:
        """Start, or fail with a reason."""
        self.readings: list[float] = []  # [N], one per tick
        self.end = self.cell.time + self.duration
        if self.object not in self.gripper.held:
            self.fail(f"the gripper does not hold '{self.object}'")

    def update(self) -> Status:
        """Read the force once per tick, without waiting."""
        self.readings.append(self.cell.contacts.wrench(self.object).force[2])
        if self.cell.time < self.end:
            return Status.RUNNING
        self.mass = mass = sum(self.readings) / len(self.readings) / GRAVITY
        self.feedback_message = f"{1e3 * mass:.1f} g"
        return Status.SUCCESS

    def get_state(self) -> dict[str, Any]:
        """Return the state for snapshots."""
        return {**super().get_state(), "readings": list(self.readings), "end": self.end}

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore the state."""
        super().set_state(state)
        self.readings, self.end = list(state["readings"]), state["end"]


def station_with_a_cube(mass: float = 0.0565) -> Station:
    """Build a station with a cube on the table."""
    station = build_station()
    station.cell.add(Cube(mass=mass), pose((0.35, 0.1, 1.04)), name="cube")
    return station


def hold(name: str) -> list[Action]:
    """Return the behaviours to pick and lift an object."""
    return [Hover(object=name), Reach(object=name), Grasp(object=name), Lift()]


@pytest.mark.parametrize("mass", [0.05, 0.2])  # [kg]
def test_it_weighs_what_the_fingers_hold(mass):
    """Success: weigh a cube of known mass."""
    station = station_with_a_cube(mass)
    assert station.run(Sequence(*hold("cube"))).status is NodeStatus.SUCCESS
    tree = Tree(Weigh(object="cube", mass="{mass}"), clock=station.clock)
    assert station.run(tree).status is NodeStatus.SUCCESS
    assert tree.blackboard["mass"] == pytest.approx(mass, rel=0.02)


def test_it_fails_when_the_object_is_not_held():
    """Failure: the cube still lies on the table."""
    weigh = Weigh(object="cube", mass="{mass}")
    assert station_with_a_cube().run(weigh).status is NodeStatus.FAILURE
    assert weigh.feedback_message == "the gripper does not hold 'cube'"


def main() -> None:
    """Pick a cube and weigh it."""
    station = station_with_a_cube()
    weigh = Weigh(object="cube", mass="{mass}")
    root = Sequence("pick and weigh", *hold("cube"), weigh)
    result = station.run(Tree(root, goal=IsHolding(object="cube")))
    print(f"{result}, {weigh.feedback_message}")


if __name__ == "__main__":
    main()
