"""Queries of coloured blocks in a cell."""

from collections.abc import Mapping

from bt_manip.cell import Cell, CellError, is_on
from bt_manip_blocks.coloured_block import ColouredBlock
from bt_manip_blocks.sorting_tray import SortingTray


def blocks_in(cell: Cell) -> Mapping[str, ColouredBlock]:
    """Return all coloured blocks of a cell by name."""
    objects = cell.objects.items()
    return {name: block for name, block in objects if isinstance(block, ColouredBlock)}


def blocks_on(cell: Cell, support: str) -> list[str]:
    """Return the names of the coloured blocks in contact with an entity.

    Raises:
        CellError: If there is no such entity.
    """
    cell.find(support)
    return [name for name in blocks_in(cell) if cell.contacts.touching(name, support)]


def tower_on(cell: Cell, base: str) -> list[str]:
    """Return the names of the blocks of a tower from its base upwards, released and at rest."""
    tower, others = [base], [name for name in blocks_in(cell) if name != base]
    while above := [name for name in others if is_on(cell, name, tower[-1])]:
        tower.append(above[0])
        others.remove(above[0])
    return tower


def find_tray(cell: Cell, name: str) -> SortingTray:
    """Return a sorting tray.

    Raises:
        CellError: If there is no such tray.
    """
    tray = cell.find(name)
    if not isinstance(tray, SortingTray):
        raise CellError(f"'{name}' is not a sorting tray")
    return tray
