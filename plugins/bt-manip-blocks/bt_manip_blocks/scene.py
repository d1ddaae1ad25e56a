"""The table with a tray."""

from dataclasses import replace

from bt_manip import spatial
from bt_manip.scenes import Level, Scene, SceneObject, table_and_basket


def table_and_tray() -> Scene:
    """Return the scene of the robot's table with a sorting tray beside the blocks' region."""
    scene = table_and_basket()
    table = next(known for known in scene.objects if known.name == "table")
    surface = scene.T_wb.translation[2]
    tray = SceneObject(
        "sorting_tray", "tray", spatial.pose((0.38, 0.24, surface)), within_reach=True
    )
    wide = Level(settings={"region": "0.2;0.55;-0.4;0.05"})
    return replace(scene, objects=(table, tray), levels={"pose": {1: Level(), 2: wide}})
