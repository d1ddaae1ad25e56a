"""Locking of the joints of a model that a robot's description leaves out."""

from collections.abc import Iterator, Sequence
from typing import Any

from dm_control import mjcf

_REFERRING = ("actuator", "equality", "sensor")
_REFERENCES = ("joint", "joint1", "joint2", "jointinparent", "tendon", "tendon1", "tendon2")


def lock_other_joints(root: mjcf.RootElement, arm: Sequence[Any]) -> bool:
    """Lock the joints that are neither an arm's nor its gripper's, at their reference positions.

    They belong to the other arm of a model with two, to a mobile base, a torso or a head. Nothing
    would hold them. Actuators, equalities, sensors and tendons on these joints are removed. Joints
    beyond the arm's first one that an equality couples belong to the arm's mechanism.

    Args:
        root: The model of the arm.
        arm: The arm's joints, from the base to the tool.

    Returns:
        Whether there was any.
    """
    base, last, own = arm[0].parent, arm[-1].parent, {id(joint) for joint in arm}
    coupled = {id(j) for one in root.find_all("equality") for j in _referred(one)}
    locked = []
    for joint in root.find_all("joint"):
        bodies = [id(body) for body in _bodies(joint)]
        if id(joint) in own or id(last) in bodies[joint.parent is last :]:
            continue  # the arm's, or beyond its last link
        if id(base) not in bodies or id(joint) not in coupled:
            locked.append(joint)
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


def _referred(element: Any) -> list[Any]:
    """Return the joints that an equality couples: named ones, or the joints above its bodies."""
    found = [getattr(element, name, None) for name in ("joint1", "joint2")]
    for name in ("body1", "body2"):
        body = getattr(element, name, None)
        while body is not None and body.tag == "body":
            found += body.find_all("joint", immediate_children_only=True)
            body = body.parent
    return [joint for joint in found if joint is not None]


def _refers(element: Any, gone: set[int]) -> bool:
    """Return whether an element refers to one of these joints and tendons."""
    return any(id(getattr(element, name, None)) in gone for name in _REFERENCES)
