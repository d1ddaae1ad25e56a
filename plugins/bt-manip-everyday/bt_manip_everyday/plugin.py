"""Hooks of this package."""

from collections.abc import Callable
from pathlib import Path

from bt_manip import hookimpl

HERE = Path(__file__).parent


@hookimpl
def register_objects(register: Callable[..., None]) -> None:
    """Register the mug, the bowl and the cans."""
    from bt_manip_everyday import objects

    for make in (
        objects.CoffeeMug, objects.Bowl,
        objects.RedCan, objects.GreenCan, objects.BlueCan, objects.YellowCan,
    ):  # fmt: skip
        register(make.kind, make)


@hookimpl
def register_behaviours(register: Callable[..., None]) -> None:
    """Register the node that reads a sentence, and its goal condition."""
    from bt_manip_everyday.sentences import HoldsExactly, ReadSentence

    register(ReadSentence)
    register(HoldsExactly)


@hookimpl
def register_scenes(register: Callable[..., None]) -> None:
    """Register the scenes of the tasks, with their variations."""
    from bt_manip.scenes import scene_of

    for path in sorted((HERE / "scenes").glob("*.toml")):
        register(path.stem, scene_of(path))


@hookimpl
def register_trees(register: Callable[..., None]) -> None:
    """Register the tasks, each with its scene."""
    for name in ("mug_on_shelf", "cans_into_box"):
        register(name, HERE / "trees" / f"{name}.xml", scene=name)
