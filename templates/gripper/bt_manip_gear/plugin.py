"""Hooks of this package."""

from bt_manip import hookimpl


@hookimpl
def register_grippers(register):
    """Register the kind of gripper."""
    from bt_manip_gear.gear import Gear

    register("gear", Gear)


@hookimpl
def register_robots(register):
    """Register an arm with the gripper, for the tests."""
    from pathlib import Path

    from bt_manip.robots import read_description

    register(read_description(Path(__file__).parent / "gear.toml"))
