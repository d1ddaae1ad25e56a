"""The pick and place task in Python: the same tree as ``pick_place.xml``.

Run it: ``bt-manip run path/to/pick_place.py:pick_place``. ``--set`` sets its arguments.
"""

from py_trees.behaviour import Behaviour

from bt_manip.behaviours import (
    BackOff,
    Drop,
    Grasp,
    Hover,
    IsHolding,
    IsIn,
    Lift,
    MoveHome,
    OpenGripper,
    Reach,
    RemoveObject,
    SpawnObject,
    WaitUntilAtRest,
    WaitUntilUndisturbed,
)
from bt_manip.bt import (
    Fallback,
    ForceSuccess,
    RetryUntilSuccessful,
    Sequence,
    Sleep,
    SubTree,
    Tree,
    TryCatch,
)


def pick_place(
    cube: str = "auto",
    basket: str = "basket",
    region: str = "auto",
    height: str = "auto",
    drop_height: str = "auto",
    force: str = "auto",
    blend_radius: float = 0.0,
    attempts: int = 3,
) -> Tree:
    """Pick a cube from a random pose on the table and drop it into the basket.

    Args:
        cube: Object to pick: a name of bt-manip list objects, or the address of a model; auto: the
            cube, smaller if the gripper opens less than 5 cm.
        basket: Name of the container in the cell.
        region: Region in which the object is added: x_min;x_max;y_min;y_max [m]; auto:
            0.2;0.4;-0.3;0.3, or the part of the table that the robot reaches from above.
        height: Height of hovering and lifting above the object [m]; auto: 0.4, or as high as the
            robot reaches.
        drop_height: Height of the tool above the basket's bottom [m]; auto: 0.25, or as high as
            the robot reaches.
        force: Normal force of each finger [N]; auto: 50, or 0.8 of the gripper's maximum if lower.
        blend_radius: Distance of the tool from the end of Hover and Lift at which the next motion
            may start [m]; 0: the arm stops.
        attempts: Number of attempts to pick and drop.
    """
    root = Sequence(
        "pick and place",
        SpawnObject(model=cube, on="table", region=region, object="{object}"),
        TryCatch(
            "or clean up",
            RetryUntilSuccessful(
                "until it is in",
                attempt(basket, force, height, drop_height, blend_radius),
                num_attempts=attempts,
            ),
            RemoveObject(object="{object}"),
            SubTree("clean up", clean_up(), object="{object}"),
        ),
    )
    goal = IsIn(object="{object}", container=basket)
    return Tree(root, goal=goal, task="put the object into the basket", continues=True)


def attempt(
    basket: str, force: str, height: str, drop_height: str, blend_radius: float
) -> Behaviour:
    """Bring the object into the basket from its present place.

    An attempt waits until the object rests and no force acts on the arm, then continues from the
    present state: an object in the basket stays there, one in the gripper is not picked again.
    After a failure the arm pauses and backs off along the path just travelled.
    """
    pick_and_drop = TryCatch(
        "or back off",
        WaitUntilUndisturbed(),
        WaitUntilAtRest(object="{object}"),
        Fallback(
            "in the basket",
            IsIn(object="{object}", container=basket),
            Sequence(
                "bring it there",
                Fallback(
                    "in the gripper",
                    IsHolding(object="{object}"),
                    SubTree("pick", pick(force, height, blend_radius), object="{object}"),
                ),
                Drop(container=basket, height=drop_height),
            ),
        ),
        Sequence("back off", Sleep(msec=500), WaitUntilUndisturbed(), BackOff(distance=0.1)),
    )
    return SubTree("attempt", pick_and_drop, object="{object}")


def pick(force: str, height: str, blend_radius: float) -> Behaviour:
    """Pick the object."""
    return Sequence(
        "pick once",
        OpenGripper(),
        Hover(object="{object}", height=height, blend_radius=blend_radius),
        Reach(object="{object}"),
        Grasp(object="{object}", force=force),
        Lift(height=height, blend_radius=blend_radius),
    )


def clean_up() -> Behaviour:
    """Remove the object in any case, so that the next cycle starts clean."""
    return Sequence(
        "leave nothing",
        ForceSuccess("open", OpenGripper()),
        ForceSuccess("go home", MoveHome()),
        RemoveObject(object="{object}"),
    )
