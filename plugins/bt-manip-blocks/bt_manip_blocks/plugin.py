"""Hooks of this package."""

from collections.abc import Callable
from pathlib import Path

from bt_manip import hookimpl

TREES = Path(__file__).parent / "trees"


@hookimpl
def register_objects(register: Callable[..., None]) -> None:
    """Register block and tray."""
    from bt_manip_blocks.coloured_block import ColouredBlock
    from bt_manip_blocks.sorting_tray import SortingTray

    register("coloured_block", ColouredBlock)
    register("sorting_tray", SortingTray)


@hookimpl
def register_behaviours(register: Callable[..., None]) -> None:
    """Register the behaviours and conditions of the tasks."""
    from bt_manip_blocks.choose_block import ChooseBase, ChooseBlock
    from bt_manip_blocks.conditions import AreSorted, AreStacked
    from bt_manip_blocks.find_slot import FindSlot
    from bt_manip_blocks.scatter_blocks import ScatterBlocks

    for cls in (ScatterBlocks, ChooseBase, ChooseBlock, FindSlot, AreSorted, AreStacked):
        register(cls)


@hookimpl
def register_scenes(register: Callable[..., None]) -> None:
    """Register the table with a tray."""
    from bt_manip_blocks.scene import table_and_tray

    register("table_and_tray", table_and_tray)


@hookimpl
def register_trees(register: Callable[..., None]) -> None:
    """Register the trees with their scene, the table with a tray."""
    for name in ("stack_blocks", "sort_blocks"):
        register(name, TREES / f"{name}.xml", scene="table_and_tray")
