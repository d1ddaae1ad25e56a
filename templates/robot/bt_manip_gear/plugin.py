"""What this package brings to bt-manip."""

from bt_manip import hookimpl


@hookimpl
def register_robots(register):
    """Bring the robot."""
    from bt_manip_gear.gear import gear

    register(gear())
