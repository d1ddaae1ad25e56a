"""The Franka hand."""

from collections.abc import Callable
from typing import Any

from bt_manip.robots import DeviceError, GripperDevice, GripperState

from .address import Address
from .errors import device_error, libfranka

TOLERANCE = 0.01  # [m] by which the width of a gripped object may differ from the expected one
THINNEST, WIDEST = 0.001, 0.08  # [m] where any width is expected


class FrankaHand(GripperDevice):
    """A Franka hand by libfranka, whose commands hold Python's lock while they block."""

    def __init__(self, address: str) -> None:
        """Parse the address; `connect` connects."""
        self._host = Address.parse(address).host
        self._gripper: Any = None

    def connect(self) -> None:
        """Connect."""
        self._gripper = self._call(libfranka().Gripper, self._host)

    def close(self) -> None:
        """Disconnect; the fingers stay where they are."""
        self._gripper = None

    def home(self) -> None:
        """Open as far as the fingers go."""
        if not self._call(self._connected().homing):
            raise DeviceError("homing failed", self._host, "free the fingers")

    def read(self) -> GripperState:
        """Return width and flag; the flag stays when an object slips, the width shrinks."""
        state = self._call(self._connected().read_once)
        return GripperState(state.width, state.is_grasped)

    def grasp(self, width: float, speed: float, force: float) -> bool:
        """Close until something is between the fingers; tell whether its width is as expected.

        A width of 0 expects an object of any width.
        """
        inner = outer = TOLERANCE
        if width == 0.0:
            width = (THINNEST + WIDEST) / 2
            inner = outer = (WIDEST - THINNEST) / 2
        return self._call(self._connected().grasp, width, speed, force, inner, outer)

    def move(self, width: float, speed: float) -> bool:
        """Move to a width."""
        return self._call(self._connected().move, width, speed)

    def _connected(self) -> Any:
        if self._gripper is None:
            raise DeviceError("not connected", self._host)
        return self._gripper

    def _call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return function(*arguments)
        except Exception as error:  # pylibfranka's have no common base
            if isinstance(error, libfranka().NetworkException):
                self.close()
            raise device_error(error, f"{self._host} (gripper)") from None
