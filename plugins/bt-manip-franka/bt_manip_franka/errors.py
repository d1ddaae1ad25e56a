"""libfranka's errors as reasons that a person understands, and its import."""

from types import ModuleType
from typing import Any

from bt_manip.exceptions import one_line
from bt_manip.robots import DeviceError

MODES = {
    "Other": "the arm is not ready (unlock its joints and activate FCI in Desk)",
    "Guiding": "the arm is guided by hand",
    "UserStopped": "user_stop (release the user stop or the emergency stop)",
    "AutomaticErrorRecovery": "the arm is recovering from an error",
}
"""Modes in which the arm does not move, whatever is commanded, and which it leaves by itself."""

BY_HAND = frozenset({"joint_position_limits_violation"})
"""Errors that need a person, who moves the arm back in Desk."""

REMEDIES = (
    ("Connection to FCI refused", "activate FCI in Desk, and check the address"),
    ("library version", "install the pylibfranka that fits the robot's system version"),
    ("timeout", "check the cable, the address, and that no other client is connected"),
    ("realtime", "use a real-time kernel and its permissions, or '?realtime=ignore'"),
)


def libfranka() -> ModuleType:
    """Import pylibfranka.

    Raises:
        DeviceError: If it is not installed.
    """
    try:
        import pylibfranka
    except ImportError as error:
        raise DeviceError(
            f"pylibfranka cannot be imported: {one_line(error)}",
            remedy="it has wheels for Linux with Python 3.11 and 3.12 only",
        ) from None
    return pylibfranka


def device_error(error: Exception, where: str) -> DeviceError:
    """Return an exception of pylibfranka as an error with a remedy."""
    text = one_line(error).removeprefix("libfranka: ").removeprefix("libfranka gripper: ")
    remedy = next((r for part, r in REMEDIES if part.lower() in text.lower()), "")
    return DeviceError(text, where, remedy)


def active(errors: Any) -> list[str]:
    """Return the names of the active errors of an ``Errors``."""
    names = (name for name in dir(type(errors)) if not name.startswith("_"))
    return [name for name in names if getattr(errors, name) is True]


def problem(state: Any) -> tuple[str, bool]:
    """Return why the arm does not move, and whether automatic recovery clears it.

    Args:
        state: A ``RobotState``.
    """
    mode = state.robot_mode.name
    if mode in MODES:
        return MODES[mode], False
    if mode != "Reflex" and not state.current_errors:
        return "", False
    names = active(state.current_errors) or active(state.last_motion_errors)
    return described(names, state) or "reflex", BY_HAND.isdisjoint(names)


def described(names: list[str], state: Any) -> str:
    """Return names of errors in one line; reflexes with the joints or axes that collided."""
    joints = _numbers(state.joint_collision)
    axes = [axis for axis, hit in zip("xyz", state.cartesian_collision, strict=False) if hit]
    where = {
        "joint_reflex": f", joint {joints}" if joints else "",
        "cartesian_reflex": f", along {' and '.join(axes)}" if axes else "",
    }
    return "; ".join(name + where.get(name, "") for name in names)


def _numbers(flags: Any) -> str:
    return " and ".join(str(number) for number, hit in enumerate(flags, 1) if hit)
