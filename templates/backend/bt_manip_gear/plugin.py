"""The parts that this package registers."""

from bt_manip import hookimpl


@hookimpl
def register_backends(register):
    """Register the backend; the driver is imported in the process that speaks to the arm."""
    from bt_manip.robots import Backend

    register(
        "gear",
        Backend(
            arm="bt_manip_gear.gear:Gear",
            controllers=("position",),
            address="the host of the arm's controller",
        ),
    )
