"""Hooks of this package."""

from bt_manip import hookimpl


@hookimpl
def register_faults(register):
    """Register the fault."""
    from bt_manip_gear.gear import Gear

    register("gear", Gear)
