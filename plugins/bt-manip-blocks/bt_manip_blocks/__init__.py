"""Coloured blocks, to stack and to sort into a tray."""

from bt_manip_blocks.choose_block import ChooseBase as ChooseBase
from bt_manip_blocks.choose_block import ChooseBlock as ChooseBlock
from bt_manip_blocks.coloured_block import COLOURS as COLOURS
from bt_manip_blocks.coloured_block import ColouredBlock as ColouredBlock
from bt_manip_blocks.conditions import AreSorted as AreSorted
from bt_manip_blocks.conditions import AreStacked as AreStacked
from bt_manip_blocks.find_slot import FindSlot as FindSlot
from bt_manip_blocks.scatter_blocks import ScatterBlocks as ScatterBlocks
from bt_manip_blocks.sorting_tray import SortingTray as SortingTray
