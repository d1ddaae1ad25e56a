"""The leaves that this package brings, beside those that control their children."""

from bt_manip.bt import Node
from bt_manip_moveit_pro import (
    interface,
    motions,
    planning_scene,
    poses,
    task_constructor,
    vectors,
)

BASES = {"Leaf", "RobotLeaf", "SceneLeaf", "VectorLeaf", "Stage", "PlanExecution"}

LEAVES: tuple[type[Node], ...] = tuple(
    cls
    for module in (poses, vectors, interface, planning_scene, motions, task_constructor)
    for cls in vars(module).values()
    if isinstance(cls, type)
    and issubclass(cls, Node)
    and cls.__module__ == module.__name__
    and cls.__name__ not in BASES
)
