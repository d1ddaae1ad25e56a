"""Named grippers: those of registered robots, and a built suction cup."""

from pathlib import Path, PurePosixPath

from bt_manip.exceptions import did_you_mean
from bt_manip.registry import Parts
from bt_manip.robots import MENAGERIE, RobotDescription, RobotError

CUP = "suction"
"""Kind of gripper of a suction cup, and name of one that is built at the flange."""


def known_grippers(parts: Parts) -> dict[str, RobotDescription]:
    """Return the registered robots whose gripper has its own model, by the model's name."""
    found: dict[str, RobotDescription] = {}
    for name in parts.robots:
        description = parts.robots.get(name)
        if description.gripper is not None and description.gripper.model is not None:
            found.setdefault(_parts(description.gripper.model)[0], description)
    return found


def gripper_names(parts: Parts) -> list[str]:
    """Return the names that ``--gripper`` accepts besides models."""
    return sorted([*known_grippers(parts), CUP])


def find_gripper(name: str, parts: Parts) -> tuple[str, RobotDescription | None]:
    """Return the name or model of a gripper, and the registered robot whose parameters apply.

    The robot has a gripper of this name, or the same model of a hand. Two-finger models are not
    looked up: their fingers are measured. Other names are looked up in Menagerie.

    Args:
        name: Name of the gripper, or path or address of its model.
        parts: The registered parts.

    Raises:
        RobotError: If no such gripper or model exists.
    """
    known = known_grippers(parts)
    if name == CUP or name in known:
        return name, known.get(name)
    if not (name.startswith(MENAGERIE) or Path(name).is_file()):
        others = menagerie_grippers()
        if name not in others:
            names = {*gripper_names(parts), *others}
            raise RobotError(
                f"there is no gripper or model '{name}'{did_you_mean(name, names)} (--gripper)"
            )
        name = others[name]
    for description in known.values():
        gripper = description.gripper
        assert gripper is not None and gripper.model is not None
        if gripper.kind != "two_finger" and _parts(gripper.model) == _parts(name):
            return name, description
    return name, None


def _parts(model: str) -> tuple[str, str]:
    """Return the folder name and the stem of a model file."""
    path = PurePosixPath(model.removeprefix(MENAGERIE).replace("\\", "/"))
    return path.parent.name or path.stem, path.stem


def menagerie_grippers() -> dict[str, str]:
    """Return the addresses of Menagerie's grippers and hands by name; of pairs the right hand."""
    import mujoco_menagerie as menagerie

    robots = [menagerie.get(name) for name in menagerie.names()]
    return {
        robot.name: f"menagerie:{robot.name}/"
        + ("right_hand" if "right_hand" in robot.entry_names else robot.default_model)
        for robot in robots
        if robot.category == "end_effector"
    }
