"""Hooks of this package."""

from bt_manip import hookimpl


@hookimpl
def register_recorders(register):
    """Register the recorder."""
    from bt_manip_gear.gear import Gear

    register("gear", Gear)
