"""A tree for the contract of scenes: it moves whatever robots there are."""

from bt_manip.behaviours import (
    CloseGripper,
    MoveHome,
    OpenGripper,
    RemoveObject,
    Retreat,
    SpawnObject,
)
from bt_manip.bt import ForceSuccess, Node, ParallelAll, Sequence

OBJECT = "contract_cube"


def exercise(robots: str = "") -> Node:
    """Return a tree that adds a cube, moves the arms and grippers, and removes the cube.

    A leaf that fails, such as one for a gripper that is not there, is passed over.

    Args:
        robots: Names of the robots, separated by ``;``; empty for the only one.
    """
    ports = [{"robot": name} if name else {} for name in robots.split(";")]
    near = ports[0] if len(ports) > 1 else {}
    moves = [
        _sequence(
            f"robot {i}",
            CloseGripper(patience=0.3, **chosen),
            Retreat(distance=0.03, **chosen),
            OpenGripper(patience=0.3, **chosen),
        )
        for i, chosen in enumerate(ports)
    ]
    return _sequence(
        "exercise",
        SpawnObject(name_hint=OBJECT, **near),
        ParallelAll("work", *moves, max_failures=-1) if len(moves) > 1 else moves[0],
        RemoveObject(object=OBJECT, patience=0.1),
        *(MoveHome(**chosen) for chosen in ports),
    )


def _sequence(name: str, *nodes: Node) -> Node:
    return Sequence(name, *(ForceSuccess(node) for node in nodes))
