"""What this package brings to bt-manip."""

from bt_manip import hookimpl


@hookimpl
def register_behaviours(register):
    """Bring the behaviour."""
    from bt_manip_gear.gear import Gear

    register(Gear)
