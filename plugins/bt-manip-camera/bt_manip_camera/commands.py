"""``bt-manip camera``: calibrate a camera, and check a calibration."""

from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli import FAILED, SUCCESS, PluginGroup, complete_part, load_chosen_plugins

if TYPE_CHECKING:
    import pinocchio as pin

    from .calibration import HandEye

DISTANCE, ANGLE = 2e-3, 0.5
"""Distance [m] and angle [degrees] from which a description does not fit any more."""

HELD_SIZE = 0.06
"""Length of the sides of the black square of a tag on a hand [m]."""


@click.group(cls=PluginGroup)
def camera() -> None:
    """Calibrate a camera on a hand, or a fixed one, and check a calibration."""


OPTIONS: list[click.Parameter] = [
    click.Option(
        ["--scene"],
        default="table_with_tag",
        show_default=True,
        metavar="S",
        shell_complete=complete_part("scenes"),
        help="Scene with the camera, and an april_tag if it is on a hand: a name, or path.",
    ),
    click.Option(
        ["--robot"],
        default="panda",
        show_default=True,
        metavar="R",
        shell_complete=complete_part("robots"),
        help="Robot to use.",
    ),
    click.Option(
        ["--camera", "name"],
        default="",
        metavar="C",
        help="Name of the camera.  [default: the only one]",
    ),
    click.Option(
        ["--views"],
        type=click.IntRange(min=5),
        default=12,
        show_default=True,
        metavar="N",
        help="Number of configurations from which the tag is looked at.",
    ),
    click.Option(["--seed"], default=0, show_default=True, metavar="S", help="Seed."),
]


@camera.command(params=OPTIONS)
def calibrate(**options: Any) -> int:
    """Find where a camera is, on its robot's tool or fixed, from a tag that it sees.

    The arm looks at the tag from several configurations, or holds one before a fixed camera. Prints
    the keys of the camera for the scene file, with the residual.
    """
    import numpy as np
    import pinocchio as pin

    from .frame import difference

    found, believed, pixels = find_calibration(**options)
    distance, angle = difference(found.T_gc, believed)
    x, y, z = found.T_gc.translation
    rpy = ", ".join(f"{value:.6f}" for value in pin.rpy.matrixToRpy(found.T_gc.rotation))
    click.echo(
        f"position = [{x:.6f}, {y:.6f}, {z:.6f}]   # residual {pixels:.2f} pixels in "
        f"{found.views} views\nrpy = [{rpy}]\n"
        f"# {1e3 * distance:.1f} mm and {np.degrees(angle):.2f} degrees from the description"
    )
    return SUCCESS


@camera.command(params=OPTIONS)
def check(**options: Any) -> int:
    """Check that the description of a camera still fits.

    Exits with 1 if the camera is 2 mm or 0.5 degrees away from where it is believed to be.
    """
    import numpy as np

    from .frame import difference

    found, believed, pixels = find_calibration(**options)
    distance, angle = difference(found.T_gc, believed)
    fits = distance < DISTANCE and np.degrees(angle) < ANGLE
    click.echo(
        f"{'it fits' if fits else 'it does not fit any more'}: {1e3 * distance:.1f} mm and "
        f"{np.degrees(angle):.2f} degrees from the description; residual {pixels:.2f} pixels in "
        f"{found.views} views"
    )
    return SUCCESS if fits else FAILED


def find_calibration(
    scene: str, robot: str, name: str, views: int, seed: int
) -> "tuple[HandEye, pin.SE3, float]":
    """Return the calibration, what was believed before, and the residual [pixels]."""
    from bt_manip import build_station
    from bt_manip.cell import CellError

    from .behaviours import chosen_camera
    from .calibration import calibrate, hold_tag, take_views
    from .camera import depth_cameras
    from .tags import Tag

    station = build_station(load_chosen_plugins().parts, scene=scene, robot=robot, seed=seed)
    entities = station.cell.entities
    tags = {key: one for key, one in entities.items() if isinstance(one, Tag)}
    _, one = chosen_camera(name, depth_cameras(entities))
    number, size, at = 0, HELD_SIZE, None
    if one.mount:
        if len(tags) != 1:
            raise CellError(f"a scene to calibrate a camera in has one april_tag, not {len(tags)}")
        ((label, tag),) = tags.items()
        number, size = int(tag.parameters["number"]), float(tag.parameters["size"])
        at = station.cell.pose(label).translation
    else:
        hold_tag(station, number, size)
    found = calibrate(
        list(take_views(station, one, number=views, tag=number, size=size, at=at)), size
    )
    believed = one.expose(station.rng, station.robots).T_wc
    if one.mount:
        commanded = station.robots[one.mount]
        believed = commanded.arm.model.pose(commanded.robot.q).actInv(believed)
    return found, believed, found.residual * one.focal_length
