"""Addresses of the backend: a host, and what is set on the robot."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from bt_manip.robots import DeviceAddress


@dataclass(frozen=True)
class Address(DeviceAddress):
    """``HOST`` or ``HOST?key=value&...``.

    Attributes:
        realtime: ``"enforce"`` refuses to run without real-time scheduling, ``"ignore"`` does not,
            ``"auto"`` enforces it on a real-time kernel.
        collision_torque: Joint torque that counts as a collision [N m].
        collision_force: Force, and torque, at the tool that counts as one [N, N m].
    """

    realtime: Literal["auto", "enforce", "ignore"] = "auto"
    collision_torque: float = 20.0
    collision_force: float = 20.0

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
