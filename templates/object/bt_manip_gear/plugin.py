"""What this package brings to bt-manip."""

from bt_manip import hookimpl


@hookimpl
def register_objects(register):
    """Bring the object."""
    from bt_manip_gear.gear import Gear

    register("gear", Gear)
