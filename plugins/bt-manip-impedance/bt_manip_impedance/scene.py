"""Scenes for compliant controllers."""

from dataclasses import replace

from bt_manip import spatial
from bt_manip.runner import Fixture, Scene, table_and_basket


def button_on_table() -> Scene:
    """Return the robot's table with a button instead of the basket."""
    scene = table_and_basket()
    table = next(fixture for fixture in scene.fixtures if fixture.name == "table")
    surface = scene.T_wb.translation[2]
    button = Fixture("push_button", "button", spatial.pose((0.4, 0.1, surface)))
    return replace(scene, fixtures=(table, button))


def peg_on_table() -> Scene:
    """Return the robot's table with a peg, and a board with a hole for it."""
    scene = table_and_basket()
    table = next(fixture for fixture in scene.fixtures if fixture.name == "table")
    surface = scene.T_wb.translation[2]
    peg = Fixture("peg", "peg", spatial.pose((0.4, -0.1, surface + 0.045)), free=True)
    board = Fixture("hole_board", "board", spatial.pose((0.4, -0.3, surface)))
    return replace(scene, fixtures=(table, peg, board))
