"""``bt-manip robot``: describe robots, check and show descriptions."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from bt_manip.cli import (
    FAILED,
    SUCCESS,
    PluginGroup,
    complete_part,
    findings_of,
    json_option,
    load_chosen_plugins,
    print_json,
)
from bt_manip.exceptions import BtManipError, with_short_values
from bt_manip.files import replace_text

if TYPE_CHECKING:
    from bt_manip.robots import Robot
    from bt_manip_setup.describe import Draft

_file = click.Path(dir_okay=False, path_type=Path)
_cycles = click.option(
    "--cycles", type=click.IntRange(min=0), default=20, show_default=True, metavar="N",
    help="Cycles of pick_place with which the robot is tried; 0: it is not tried.",
)  # fmt: skip


@click.group(cls=PluginGroup)
def robot() -> None:
    """Describe a robot from its model, check and show descriptions."""


@robot.command()
@click.argument("model")
@click.option(
    "--gripper", metavar="GRIPPER",
    help="Model of a gripper, if the arm's has none; or the name of a registered one, or suction.",
)  # fmt: skip
@click.option(
    "-o", "--output", type=_file, default=Path("robot.toml"), show_default=True, metavar="FILE",
    help="File to write.",
)  # fmt: skip
@click.option("--joints", metavar="J,J,...", help="Joints of the arm.  [default: found]")
@click.option(
    "--mount", metavar="NAME", help="Site or body that carries the gripper.  [default: found]"
)
@click.option(
    "--tool-frame", metavar="NAME",
    help="Site or body between the fingers; z is the direction of approach.  [default: measured]",
)  # fmt: skip
@_cycles
@click.option("--overwrite", is_flag=True, help="Replace the file if it exists.")
def new(
    model: str,
    gripper: str | None,
    output: Path,
    joints: str | None,
    mount: str | None,
    tool_frame: str | None,
    cycles: int,
    overwrite: bool,
) -> int:
    """Write the description of a robot from its model.

    MODEL is a path of MJCF or URDF, or menagerie:NAME or menagerie:NAME/ENTRY. Limits that the
    model does not have are conservative, and marked in the file. The robot is tried: it grasps a
    cube on a post and runs pick_place. Exits with 1 if that fails.
    """
    if output.exists() and not overwrite:
        raise click.UsageError(f"{output} exists: --overwrite replaces it, -o names another file")
    os.environ.setdefault("MUJOCO_GL", "disable")
    from bt_manip.record import check_writable
    from bt_manip_setup import describe_robot, gripper_names, try_robot

    check_writable(output, "description")
    parts = load_chosen_plugins().parts
    with _progress("measures the model"):
        draft = describe_robot(
            model,
            parts,
            name=output.stem,
            gripper=gripper,
            joints=None if joints is None else joints.split(","),
            mount=mount,
            tool_frame=tool_frame,
        )
    carried = "" if gripper is None else f" with {gripper}"
    head = f"{model}{carried}\n\nWritten by bt-manip robot new."
    _write(draft, output, head)
    for line in draft.robot.warnings:
        click.echo(line, err=True)
    if draft.description.gripper is None:
        names = ", ".join(gripper_names(parts))
        kinds = f"--gripper gives it one: {names}, or a model"
        click.echo(f"no gripper: the model has none, and {kinds}", err=True)
        cycles = 0
    if not cycles:
        click.echo(f"wrote {output}, not tried; next:\n  bt-manip robot check {output}")
        return SUCCESS
    with _progress("tries the robot") as report:
        trial = try_robot(draft.description, parts, cycles, report)
    for line in trial.facts:
        click.echo(line, err=True)
    if trial.findings:
        click.echo(f"wrote {output}, which does not pick the cube:")
        for line in trial.findings:
            click.echo(line)
        head += "\n\nIt does not pick the cube yet; to change:\n" + "\n".join(trial.findings)
        _write(draft, output, head)
        return FAILED
    click.echo(f"wrote {output}, ready:\n  bt-manip run pick_place --robot {output} --view")
    return SUCCESS


@robot.command()
@click.argument("file", type=_file)
@_cycles
@click.option(
    "--picture", type=_file, metavar="FILE.png", help="Picture to save.  [default: beside FILE]"
)
@json_option
def check(file: Path, cycles: int, picture: Path | None, as_json: bool) -> int:
    """Print everything that is wrong with a description, with what to change.

    FILE is TOML. Checks keys and names, self-collision at home, the tool frame, the gripper, the
    payload, the reach, and the agreement with MuJoCo. A robot without findings is tried: it grasps
    a cube on a post and runs pick_place. Exits with 1 if there are findings.
    """
    from bt_manip_setup import check_description

    parts = load_chosen_plugins().parts
    if not file.exists() and str(file) in parts.robots.names():
        shown = f"'bt-manip robot show {file}' shows it"
        raise BtManipError(f"'{file}' is a registered robot, and check takes a file; {shown}")
    with _progress("checks the description") as report:
        checked = check_description(file, parts, cycles, report)
    if as_json:
        print_json(findings_of(checked.findings, str(file)), facts=checked.facts)
    else:
        for line in checked.findings:
            click.echo(line)
        for line in checked.facts:
            click.echo(line, err=True)
    if checked.robot is not None:
        _draw(checked.robot, picture or file.with_suffix(".png"))
    findings = len(checked.findings)
    what = f"{findings} finding{'s' if findings != 1 else ''}"
    click.echo(with_short_values(f"{file}: {what}"), err=True)
    return FAILED if findings else SUCCESS


@robot.command()
@click.argument("name", metavar="ROBOT", shell_complete=complete_part("robots"))
@click.option("--picture", type=_file, metavar="FILE.png", help="Picture to save.")
def show(name: str, picture: Path | None) -> None:
    """Print joints with limits, tool, gripper, payload and reach of a robot.

    ROBOT is a registered name or path.toml.
    """
    from bt_manip.scenes import find_robot
    from bt_manip_setup import make_robot, summary

    parts = load_chosen_plugins().parts
    robot = make_robot(find_robot(name, parts.robots), parts)
    for line in summary(robot):
        click.echo(line)
    if picture is not None:
        _draw(robot, picture)


@robot.command()
@click.argument("name", metavar="ROBOT", shell_complete=complete_part("robots"))
def measure(name: str) -> None:
    """Measure the travel of a gripper's two fingers and write it into the description.

    ROBOT is path.toml or a registered name. The model's fingers are moved over their range; the
    result is the table [gripper.travel] of the file, or the file whose path a description in Python
    has in its place. Repeat this after changes of the gripper's model.
    """
    os.environ.setdefault("MUJOCO_GL", "disable")
    from bt_manip.scenes import find_robot
    from bt_manip_setup.finger_travel import write_travel
    from bt_manip_setup.gripper_keys import has_two_fingers

    parts = load_chosen_plugins().parts
    description = find_robot(name, parts.robots)
    if not has_two_fingers(description, parts):
        raise BtManipError(f"{description.where} has no gripper with two fingers")
    path, travel = write_travel(description)
    low, high = 1e3 * travel["min_width"], 1e3 * travel["open_width"]
    click.echo(f"wrote {path}: the fingers open from {low:.4g} to {high:.4g} mm")


@contextmanager
def _progress(step: str) -> Iterator[Callable[[str], None]]:
    """Show the present step in a terminal while the context lasts; yield what changes it."""
    from rich.console import Console

    with Console(stderr=True).status(step) as status:
        yield status.update


def _write(draft: "Draft", path: Path, head: str) -> None:
    from bt_manip.record import writing
    from bt_manip_setup import description_text

    with writing(path, "description"):
        replace_text(path, description_text(draft.description, draft.notes, path, head))


def _draw(robot: "Robot", path: Path) -> None:
    """Save a picture of a robot, or say why there is none."""
    from bt_manip.cell import NoOpenGLError, write_png
    from bt_manip_setup import picture

    try:
        write_png(path, picture(robot))
        click.echo(f"wrote {path}", err=True)
    except NoOpenGLError as error:
        click.echo(f"no picture: {error}", err=True)
