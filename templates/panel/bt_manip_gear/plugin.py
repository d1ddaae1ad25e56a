"""Hooks of this package."""

from bt_manip import hookimpl


@hookimpl
def register_panels(register):
    """Register the panel."""
    from bt_manip_gear.gear import Gear

    register("gear", Gear)
