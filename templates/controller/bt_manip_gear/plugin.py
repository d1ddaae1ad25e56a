"""The parts that this package registers."""

from bt_manip import hookimpl


@hookimpl
def register_controllers(register):
    """Register the controller."""
    from bt_manip_gear.gear import Gear

    register("gear", Gear)
