"""Hooks of this package."""

from bt_manip import hookimpl


@hookimpl
def register_robots(register):
    """Register the robot."""
    from bt_manip_gear.gear import gear

    register(gear())
