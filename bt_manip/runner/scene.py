"""What stands in a cell before a tree begins."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import pinocchio as pin

from bt_manip import spatial


@dataclass(frozen=True)
class Fixture:
    """An object that stands in the cell from the beginning.

    Attributes:
        model: Registered name of the object.
        name: Its name in the cell.
        T_wo: Its pose in the world.
        parameters: What the object is made with, by keyword.
        free: Whether it can be moved; for good where not.
    """

    model: str
    name: str
    T_wo: pin.SE3
    parameters: Mapping[str, Any] = field(default_factory=dict)
    free: bool = False


@dataclass(frozen=True)
class Scene:
    """A cell as a tree finds it.

    Attributes:
        T_wb: Pose of the robot's base in the world.
        fixtures: What stands there, in the order in which it is put there.
    """

    T_wb: pin.SE3
    fixtures: tuple[Fixture, ...]


@cache
def table_and_basket() -> Scene:
    """Give the scene of the pick and place task: a robot on a table, and a basket beside it.

    Measures of gym-gz's Panda pick and place; the base stands on the table's surface, not 15 mm
    inside it.
    """
    surface = 1.015  # [m] above the floor
    quarter_turn = (0.5**0.5, 0.0, 0.0, 0.5**0.5)
    return Scene(
        T_wb=spatial.pose((-0.1, 0.0, surface)),
        fixtures=(
            Fixture("table", "table", spatial.pose((0.0, 0.0, 0.0))),
            Fixture("basket", "basket", spatial.pose((0.68, 0.0, surface), quarter_turn)),
        ),
    )
