"""Addresses of the backend: a host, and what is set on the robot."""

from dataclasses import dataclass, fields
from pathlib import Path
from urllib.parse import parse_qsl

from bt_manip.exceptions import did_you_mean, shown
from bt_manip.robots import DeviceError

REALTIME = ("auto", "enforce", "ignore")


@dataclass(frozen=True)
class Address:
    """``HOST`` or ``HOST?key=value&...``.

    Attributes:
        host: Name or IP address of the controller.
        realtime: ``"enforce"`` refuses to run without real-time scheduling, ``"ignore"`` does not,
            ``"auto"`` enforces it on a real-time kernel.
        collision_torque: Joint torque that counts as a collision [N m].
        collision_force: Force, and torque, at the tool that counts as one [N, N m].
    """

    host: str
    realtime: str = "auto"
    collision_torque: float = 20.0
    collision_force: float = 20.0

    @classmethod
    def parse(cls, text: str) -> "Address":
        """Return the address in a text.

        Raises:
            DeviceError: If it is none.
        """
        host, _, query = text.partition("?")
        if not host:
            raise DeviceError("no host in the address", text, "such as 172.16.0.2")
        values: dict[str, str | float] = dict(parse_qsl(query, keep_blank_values=True))
        names = [field.name for field in fields(cls)][1:]
        for key, value in values.items():
            if key not in names:
                raise DeviceError(f"unknown key '{key}'{did_you_mean(key, names)}", text)
            if key != "realtime":
                values[key] = _positive(key, value, text)
            elif value not in REALTIME:
                raise DeviceError(f"realtime is one of {', '.join(REALTIME)}", text)
        return cls(host, **values)

    @property
    def enforces_realtime(self) -> bool:
        """Whether libfranka is to refuse to run without real-time scheduling."""
        return self.realtime == "enforce" or (self.realtime == "auto" and realtime_kernel())


def realtime_kernel() -> bool:
    """Tell whether the kernel has PREEMPT_RT."""
    try:
        return Path("/sys/kernel/realtime").read_text().strip() == "1"
    except OSError:
        return False


def _positive(key: str, value: object, text: str) -> float:
    try:
        number = float(str(value))
    except ValueError:
        number = 0.0
    if not 0.0 < number < 1e3:
        raise DeviceError(f"{key} is a number between 0 and 1000, not {shown(value)}", text)
    return number
