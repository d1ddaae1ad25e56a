"""A button on a table."""

from dataclasses import replace

from bt_manip import spatial
from bt_manip.runner import Fixture, Scene, table_and_basket


def button_on_table() -> Scene:
    """Give the robot's table with a button in the place of the basket."""
    scene = table_and_basket()
    table = next(fixture for fixture in scene.fixtures if fixture.name == "table")
    surface = scene.T_wb.translation[2]
    button = Fixture("push_button", "button", spatial.pose((0.4, 0.1, surface)))
    return replace(scene, fixtures=(table, button))
