"""Scenes for compliant controllers."""

from dataclasses import replace

from bt_manip import spatial
from bt_manip.cell.randomization import Randomization
from bt_manip.scenes import Fixture, Scene, table_and_basket


def button_on_table() -> Scene:
    """Return the robot's table with a button instead of the basket."""
    scene = table_and_basket()
    table = next(fixture for fixture in scene.fixtures if fixture.name == "table")
    surface = scene.T_wb.translation[2]
    button = Fixture("push_button", "button", spatial.pose((0.4, 0.1, surface)))
    return replace(scene, fixtures=(table, button))


def peg_on_table() -> Scene:
    """Return the robot's table with a peg, back in its place in each cycle, and a board for it."""
    scene = table_and_basket()
    table = next(fixture for fixture in scene.fixtures if fixture.name == "table")
    surface = scene.T_wb.translation[2]
    at = (0.4, -0.1, surface + 0.045)
    peg = Fixture("peg", "peg", spatial.pose(at), free=True)
    board = Fixture("hole_board", "board", spatial.pose((0.4, -0.3, surface)))
    again = Randomization(objects={"peg": {"position": at}})
    return replace(scene, fixtures=(table, peg, board), randomization=again)
