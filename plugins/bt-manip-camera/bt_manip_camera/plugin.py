"""Hooks of this package."""

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_manip import hookimpl

if TYPE_CHECKING:
    from bt_manip.runner import Run, RunModifier

HERE = Path(__file__).parent

BLOCKS = "bt_manip_blocks"
"""The package whose behaviours some trees need; they are there where it is installed."""


@hookimpl
def register_commands(register: Callable[..., None]) -> None:
    """Register ``bt-manip camera``."""
    register("camera", "bt_manip_camera.commands:camera")


def camera(run: "Run", texts: Sequence[str], warn: Callable[[str], None]) -> "RunModifier":
    """Take the frames of a depth_camera from a server, or of a folder; may be given repeatedly."""
    from bt_manip_camera.sources import connect

    return connect(run, texts)


camera.metavar = "NAME=[HOST:]PORT"  # type: ignore[attr-defined]
camera.group = "Real robot"  # type: ignore[attr-defined]
camera.real = True  # type: ignore[attr-defined]


@hookimpl
def register_modifiers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the option ``--camera``."""
    register("camera", camera)


@hookimpl
def register_objects(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the camera, and what it can read."""
    from bt_manip_camera.camera import DepthCamera
    from bt_manip_camera.tags import Tag

    register(DepthCamera.kind, DepthCamera)
    register(Tag.kind, Tag)


@hookimpl
def register_behaviours(register: Callable[[type[Any]], None]) -> None:
    """Register what looks."""
    from bt_manip_camera import behaviours as ours

    register(ours.DetectTags)
    register(ours.EstimatePose)
    register(ours.IsSeen)
    register(ours.LookAt)
    register(ours.SeeObjects)
    register(ours.SegmentTable)
    register(ours.WaitUntilSeen)


@hookimpl
def register_pose_sources(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register seen poses."""
    from bt_manip_camera.seen import SeenPoses

    register("seen", SeenPoses)


@hookimpl
def register_scenes(register: Callable[..., None]) -> None:
    """Register the scenes of the trees."""
    from bt_manip.scenes import scene_of

    blocks = ["table_and_tray_seen"] if find_spec(BLOCKS) else []
    for name in ("table_seen", "table_with_tag", *blocks):
        register(name, scene_of(HERE / "scenes" / f"{name}.toml"))


@hookimpl
def register_trees(register: Callable[..., None]) -> None:
    """Register the trees, with their scenes."""
    scenes = {"pick_place_seen": "table_seen"}
    if find_spec(BLOCKS):
        scenes |= dict.fromkeys(("stack_blocks_seen", "sort_blocks_seen"), "table_and_tray_seen")
    for name, scene in scenes.items():
        register(name, HERE / "trees" / f"{name}.xml", scene=scene)


@hookimpl(optionalhook=True)
def register_faults(register: Callable[[str, type], None]) -> None:
    """Register the faults of cameras."""
    from bt_manip_camera import faults

    register("camera_covered", faults.CameraCovered)
    register("camera_delay", faults.CameraDelay)
    register("camera_dropout", faults.CameraDropout)
    register("camera_moved", faults.CameraMoved)
    register("lights_out", faults.LightsOut)
    register("look_alike", faults.LookAlike)


@hookimpl(optionalhook=True)
def register_panels(register: Callable[[str, Callable[[Any], Any]], None]) -> None:
    """Register the panel of seen poses."""
    from bt_manip_camera.panel import SeenPanel

    register("seen", SeenPanel)


@hookimpl(optionalhook=True)
def register_message_sources(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register what recordings have of seen poses."""

    def make(run: Any, add: Any) -> Any:
        from bt_manip_camera.messages import SeenMessages

        return SeenMessages(run, add)

    register("seen", make)
