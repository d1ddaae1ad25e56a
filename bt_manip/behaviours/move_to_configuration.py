"""Move the arm to a configuration."""

from dataclasses import replace
from typing import Any

from bt_manip.bt import DOUBLE_LIST, Input, is_pointer

from .moves import PlannedMove


def _parse(text: str) -> list[float] | str:
    """Read joint positions; a text without ';' that is no number names a configuration."""
    assert DOUBLE_LIST.parse is not None
    try:
        return DOUBLE_LIST.parse(text)
    except ValueError:
        if ";" in text or not text.strip():
            raise
        return text


def _format(value: list[float] | str) -> str:
    assert DOUBLE_LIST.format is not None
    return value if isinstance(value, str) else DOUBLE_LIST.format(value)


JOINTS = replace(DOUBLE_LIST, parse=_parse, format=_format)
"""Joint positions, or the name of a configuration."""


class MoveToConfiguration(PlannedMove):
    """Move the arm's joints to given positions, around obstacles."""

    configuration = Input(
        JOINTS, doc="Joint positions, separated by ';' [rad], or the name of a configuration."
    )

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell and the robots, and check the name of a configuration."""
        super().setup(**infrastructure)
        given = self.given["configuration"]
        if isinstance(given, str) and not is_pointer(given) and not _is_positions(given):
            self.arm.robot.configuration(given)

    def start(self) -> None:
        """Plan a collision-free motion; a joint-space segment where that is free."""
        wanted = self.configuration
        if isinstance(wanted, str):
            wanted = self.arm.robot.configuration(wanted)
        self.arm.move_to_configuration(wanted, speed=self.speed, **self.planning())


def _is_positions(text: str) -> bool:
    return isinstance(_parse(text), list)
