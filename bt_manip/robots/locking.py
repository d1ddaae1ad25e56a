"""Locking of the joints of a model that a robot's description leaves out."""

from collections.abc import Iterator
from typing import Any

from dm_control import mjcf

_REFERRING = ("actuator", "equality", "sensor")
_REFERENCES = ("joint", "joint1", "joint2", "jointinparent", "tendon", "tendon1", "tendon2")


def lock_other_joints(root: mjcf.RootElement, first: Any) -> bool:
    """Lock the joints that are not beyond an arm's first one, at their reference positions.

    They belong to the other arm of a model with two, or to a mobile base or a torso. Nothing would
    hold them. Actuators, equalities, sensors and tendons on these joints are removed.

    Args:
        root: The model of the arm.
        first: The arm's first joint.

    Returns:
        Whether there was any.
    """
    base = first.parent
    locked = [j for j in root.find_all("joint") if not any(body is base for body in _bodies(j))]
    if not locked:
        return False
    gone = {id(joint) for joint in locked}
    referring = [
        tendon
        for tendon in root.find_all("tendon")
        if any(_refers(wrap, gone) for wrap in tendon.all_children())
    ]
    gone |= {id(tendon) for tendon in referring}
    for kind in _REFERRING:
        referring += [element for element in root.find_all(kind) if _refers(element, gone)]
    for element in (*reversed(referring), *locked):  # what refers to others goes first
        element.remove()
    return True


def _bodies(joint: Any) -> Iterator[Any]:
    """Yield the bodies that a joint's body is in, its own first."""
    body = joint.parent
    while body is not None:
        yield body
        body = body.parent


def _refers(element: Any, gone: set[int]) -> bool:
    """Return whether an element refers to one of these joints and tendons."""
    return any(id(getattr(element, name, None)) in gone for name in _REFERENCES)
