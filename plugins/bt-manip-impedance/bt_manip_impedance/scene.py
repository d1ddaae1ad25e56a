"""Scenes for compliant controllers."""

from dataclasses import replace

from bt_manip import spatial
from bt_manip.cell.randomization import Randomization
from bt_manip.scenes import Scene, SceneObject, table_and_basket


def button_on_table() -> Scene:
    """Return the robot's table with a button instead of the basket."""
    scene = table_and_basket()
    table = next(known for known in scene.objects if known.name == "table")
    surface = scene.T_wb.translation[2]
    button = SceneObject("push_button", "button", spatial.pose((0.4, 0.1, surface)))
    return replace(scene, objects=(table, button))


def peg_on_table() -> Scene:
    """Return the robot's table with a peg, reset in each cycle, and a board with a hole."""
    scene = table_and_basket()
    table = next(known for known in scene.objects if known.name == "table")
    surface = scene.T_wb.translation[2]
    at = (0.4, -0.1, surface + 0.045)
    peg = SceneObject("peg", "peg", spatial.pose(at), free=True)
    board = SceneObject("hole_board", "board", spatial.pose((0.4, -0.3, surface)))
    again = Randomization(objects={"peg": {"position": at}})
    return replace(scene, objects=(table, peg, board), randomization=again)
