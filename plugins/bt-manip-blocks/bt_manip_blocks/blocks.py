"""Which coloured blocks there are, and where they lie."""

from collections.abc import Mapping

from bt_manip.cell import Cell, CellError, is_on
from bt_manip_blocks.coloured_block import ColouredBlock
from bt_manip_blocks.sorting_tray import SortingTray


def blocks_in(cell: Cell) -> Mapping[str, ColouredBlock]:
    """Give all coloured blocks of a cell by name."""
    objects = cell.objects.items()
    return {name: block for name, block in objects if isinstance(block, ColouredBlock)}


def blocks_on(cell: Cell, support: str) -> list[str]:
    """Name the coloured blocks that touch something.

    Raises:
        CellError: When there is no such thing.
    """
    cell.find(support)
    return [name for name in blocks_in(cell) if cell.contacts.touching(name, support)]


def tower_on(cell: Cell, base: str) -> list[str]:
    """Name the blocks of a tower upwards from its base, each above it released and at rest."""
    tower, others = [base], [name for name in blocks_in(cell) if name != base]
    while above := [name for name in others if is_on(cell, name, tower[-1])]:
        tower.append(above[0])
        others.remove(above[0])
    return tower


def find_tray(cell: Cell, name: str) -> SortingTray:
    """Give a sorting tray.

    Raises:
        CellError: When there is none of that name.
    """
    tray = cell.find(name)
    if not isinstance(tray, SortingTray):
        raise CellError(f"'{name}' is no sorting tray")
    return tray


def unsorted_blocks(cell: Cell, tray: str) -> list[str]:
    """Name the coloured blocks that do not rest on a tray, released, in the row of their colour.

    Raises:
        CellError: When there is no such tray.
    """
    rows = find_tray(cell, tray)
    T_tw = cell.pose(tray).inverse()
    return [
        name
        for name, block in blocks_in(cell).items()
        if not is_on(cell, name, tray)
        or rows.row_at(T_tw.act(cell.pose(name).translation)) != block.colour
    ]
