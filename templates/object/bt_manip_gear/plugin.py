"""Hooks of this package."""

from bt_manip import hookimpl


@hookimpl
def register_objects(register):
    """Register the object."""
    from bt_manip_gear.gear import Gear

    register("gear", Gear)
