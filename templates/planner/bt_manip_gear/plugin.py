"""What this package brings to bt-manip."""

from bt_manip import hookimpl


@hookimpl
def register_planners(register):
    """Bring the planner."""
    from bt_manip_gear.gear import Gear

    register("gear", Gear)
