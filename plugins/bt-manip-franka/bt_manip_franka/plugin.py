"""Hooks of this package."""

from collections.abc import Callable

from bt_manip import hookimpl


@hookimpl
def register_backends(register: Callable[..., None]) -> None:
    """Register the backend; libfranka is imported in the processes that speak to the robot."""
    from bt_manip.robots import Backend

    register(
        "franka",
        Backend(
            arm="bt_manip_franka.device:FrankaArm",
            gripper="bt_manip_franka.gripper:FrankaHand",
            controllers=("joint_impedance",),
            address="the controller's host, such as 172.16.0.2 or 172.16.0.2?realtime=enforce",
        ),
    )
