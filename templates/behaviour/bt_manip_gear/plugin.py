"""Hooks of this package."""

from bt_manip import hookimpl


@hookimpl
def register_behaviours(register):
    """Register the behaviour."""
    from bt_manip_gear.gear import Gear

    register(Gear)
