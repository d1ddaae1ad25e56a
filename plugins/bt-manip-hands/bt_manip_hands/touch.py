"""Sensors of the force on a body of a gripper."""

from typing import Any

_REACH = 0.3  # [m] radius of the zone, large enough for all contacts of the body


def add_touch_sensor(body: Any, name: str) -> Any:
    """Add a sensor of all contacts of a body; return its PyMJCF element."""
    # Group 5 is hidden in all viewers by default.
    site = body.add("site", name=name, type="sphere", size=(_REACH,), group=5, rgba=(0, 0, 0, 0))
    return body.root.sensor.add("touch", name=name, site=site)
