"""The built-in parts, which come through the same hooks as everyone's.

Everything is imported inside the hooks, so that this module costs nothing by itself.
"""

from collections.abc import Callable
from typing import Any

from bt_manip.hookspecs import hookimpl


@hookimpl
def register_objects(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring things to pick up, to put them in and on, and to move around."""
    from bt_manip.cell import Camera, objects

    for make in (
        objects.Cube, objects.Box, objects.Cylinder, objects.Sphere, objects.Capsule,
        objects.ConvexMesh, objects.Block, objects.RedBlock, objects.GreenBlock,
        objects.BlueBlock, objects.YellowBlock, objects.Bottle, objects.Can, objects.Mug,
        objects.Basket, objects.Bin, objects.Tray, objects.Table, objects.Shelf, objects.Wall,
        Camera,
    ):  # fmt: skip
        register(make.kind, make)


@hookimpl
def register_robots(register: Callable[[Any], None]) -> None:
    """Bring the Panda."""
    from bt_manip.robots import panda

    register(panda())


@hookimpl
def register_grippers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring the gripper of two fingers."""
    from bt_manip.grippers import TwoFingerGripper

    register(TwoFingerGripper.kind, TwoFingerGripper)


@hookimpl
def register_controllers(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring computed torque, and the plain PD beside it."""
    from bt_manip import control

    register("computed_torque", control.ComputedTorque)
    register("gravity_compensated_pd", control.GravityCompensatedPD)


@hookimpl
def register_planners(register: Callable[[str, Callable[[], Any]], None]) -> None:
    """Bring RRT-Connect."""
    from bt_manip import planning

    register("rrt_connect", planning.RRTConnect)


@hookimpl
def register_behaviours(register: Callable[..., None]) -> None:
    """Bring the behaviours of picking and placing."""
    from bt_manip import behaviours

    for name in (
        "SpawnObject", "RemoveObject", "ObjectExists", "IsIn", "IsOn",
        "WaitUntilAtRest", "WaitUntilUndisturbed",
        "Hover", "Reach", "Grasp", "Lift", "Drop", "PlaceOn", "PlaceAt", "IsHolding",
        "OpenGripper", "CloseGripper",
        "MoveToPose", "MoveToConfiguration", "MoveHome", "MoveLinear", "MoveThrough", "MoveArc",
        "Approach", "Retreat", "BackOff",
        "FollowTarget", "Stop", "Recover", "SetSpeed", "SwitchController", "IsAt",
    ):  # fmt: skip
        register(getattr(behaviours, name))


@hookimpl
def register_trees(register: Callable[..., None]) -> None:
    """Bring all trees that travel with the package, each with its scene where it needs one."""
    from bt_manip.models import bundled_root

    for path in sorted(bundled_root("trees").glob("*.xml")):
        register(path.stem, path, scene={"two_arms": "two_arms"}.get(path.stem))


@hookimpl
def register_scenes(register: Callable[[str, Callable[[], Any]], None]) -> None:
    """Bring the scene of the pick and place task, one with two robots, and those in files."""
    from bt_manip.models import bundled_root
    from bt_manip.scenes import scene_of, table_and_basket, two_arms

    register("table_and_basket", table_and_basket)
    register("two_arms", two_arms)
    for path in sorted(bundled_root("scenes").glob("*.toml")):
        register(path.stem, scene_of(path))


@hookimpl
def register_model_sources(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the bundled models, MuJoCo Menagerie and ROS packages as sources."""
    from bt_manip.models import built_in_sources

    for kind, find in built_in_sources().items():
        register(kind, find)


@hookimpl
def register_model_formats(register: Callable[[str, Any], None]) -> None:
    """Bring MJCF, URDF and meshes."""
    from bt_manip.models import built_in_formats

    for name, one in built_in_formats().items():
        register(name, one)


@hookimpl
def register_model_caches(register: Callable[[str, Callable[[], Any]], None]) -> None:
    """Bring the downloaded models of Menagerie."""
    from bt_manip.models import MenagerieCache

    register("menagerie", MenagerieCache)


@hookimpl
def register_pose_sources(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Bring the poses that a scene describes, confirmed by an operator or not."""
    from bt_manip.scenes import OperatorPoses, ScenePoses

    register("scene", ScenePoses)
    register("operator", OperatorPoses)
