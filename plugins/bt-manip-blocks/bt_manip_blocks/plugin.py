"""Hooks of this package."""

from pathlib import Path

from bt_manip import hookimpl

TREES = Path(__file__).parent / "trees"


@hookimpl
def register_objects(register):
    """Bring blocks and tray."""
    from bt_manip_blocks.coloured_block import ColouredBlock
    from bt_manip_blocks.sorting_tray import SortingTray

    register("coloured_block", ColouredBlock)
    register("sorting_tray", SortingTray)


@hookimpl
def register_behaviours(register):
    """Register the behaviours that scatter blocks, choose one, find its slot, and check the end."""
    from bt_manip_blocks.choose_block import ChooseBase, ChooseBlock
    from bt_manip_blocks.conditions import AreSorted, AreStacked
    from bt_manip_blocks.find_slot import FindSlot
    from bt_manip_blocks.scatter_blocks import ScatterBlocks

    for cls in (ScatterBlocks, ChooseBase, ChooseBlock, FindSlot, AreSorted, AreStacked):
        register(cls)


@hookimpl
def register_scenes(register):
    """Bring the table with the tray on it."""
    from bt_manip_blocks.scene import table_and_tray

    register("table_and_tray", table_and_tray)


@hookimpl
def register_trees(register):
    """Bring the trees, which work on the table with the tray."""
    for name in ("stack_blocks", "sort_blocks"):
        register(name, TREES / f"{name}.xml", scene="table_and_tray")
