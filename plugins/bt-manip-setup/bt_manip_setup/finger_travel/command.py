"""``bt-manip robot measure``: measure the fingers of a robot's gripper."""

import os

import click

from bt_manip.cli import complete_part, load_chosen_plugins
from bt_manip.exceptions import BtManipError


@click.command()
@click.argument("name", metavar="ROBOT", shell_complete=complete_part("robots"))
def measure(name: str) -> None:
    """Measure the travel of a gripper's two fingers and write it into the description.

    ROBOT is path.toml or a registered name. The model's fingers are moved over their range; the
    result is the table [gripper.travel] of the file, or the file whose path a description in Python
    has in its place. Repeat this after changes of the gripper's model.
    """
    os.environ.setdefault("MUJOCO_GL", "disable")
    from bt_manip.grippers import TwoFingerGripper
    from bt_manip.scenes import find_robot
    from bt_manip_setup.finger_travel import write_travel

    parts = load_chosen_plugins().parts
    description = find_robot(name, parts.robots)
    if description.gripper is None:
        raise BtManipError(f"{description.where} has no gripper")
    kind = parts.grippers.get(description.gripper.kind)
    if not (isinstance(kind, type) and issubclass(kind, TwoFingerGripper)):
        raise BtManipError(
            f"{description.where}: grippers of kind '{description.gripper.kind}' have no travel to "
            "measure"
        )
    path, travel = write_travel(description)
    low, high = 1e3 * travel["min_width"], 1e3 * travel["open_width"]
    click.echo(f"wrote {path}: the fingers open from {low:.4g} to {high:.4g} mm")
