"""Hooks of this package."""

from bt_manip import hookimpl


@hookimpl
def register_planners(register):
    """Register the planner."""
    from bt_manip_gear.gear import Gear

    register("gear", Gear)
