"""The pick and place task in Python: the same tree as ``pick_place.xml``.

Run it: ``bt-manip run path/to/pick_place.py:pick_place``. Its arguments are what ``--set`` sets.
"""

from py_trees.behaviour import Behaviour

from bt_manip.behaviours import (
    Drop,
    Grasp,
    Hover,
    IsHolding,
    Lift,
    MoveHome,
    OpenGripper,
    Reach,
    RemoveObject,
    SpawnObject,
)
from bt_manip.bt import RetryUntilSuccessful, Sequence, SubTree, TryCatch


def pick_place(
    cube: str = "cube", basket: str = "basket", force: float = 50.0, attempts: int = 3
) -> Behaviour:
    """Pick a cube from a random place on the table and drop it into the basket.

    Args:
        cube: Object to pick: a name of bt-manip list objects, or the address of a model.
        basket: Name of the container in the cell.
        force: Normal force of each finger [N].
        attempts: How often a pick is tried.
    """
    return Sequence(
        "pick and place",
        SpawnObject(model=cube, on="table", region="0.2;0.4;-0.3;0.3", object="{object}"),
        TryCatch(
            "or clean up",
            RetryUntilSuccessful("pick", attempt(force), num_attempts=attempts),
            Drop(container=basket, height=0.25),
            RemoveObject(object="{object}"),
            SubTree("give up", give_up(), object="{object}"),
        ),
    )


def attempt(force: float) -> Behaviour:
    """Pick the object once."""
    pick = Sequence(
        "pick once",
        OpenGripper(),
        Hover(object="{object}", height=0.4),
        Reach(object="{object}"),
        Grasp(object="{object}", force=force),
        Lift(height=0.4),
        IsHolding(object="{object}"),
    )
    return SubTree("attempt", pick, object="{object}")


def give_up() -> Behaviour:
    """Leave no object behind, so that the next cycle starts clean."""
    return Sequence("clean up", OpenGripper(), MoveHome(), RemoveObject(object="{object}"))
