"""The interface of the panels of the page."""

from typing import Any

from bt_manip.runner import RunEvent


class Panel:
    """A part of the page; its methods are called by the thread of the run."""

    def start(self, run: Any) -> None:
        """Prepare for a run, with `.request`, `.station` and `.tree`."""

    def handle(self, event: RunEvent) -> None:
        """Note an event; drawing comes later."""

    def end_tick(self) -> None:
        """Sample the state after a tick, in some microseconds."""

    def draw(self) -> None:
        """Send what has changed to the open pages; called at most ten times a second."""
