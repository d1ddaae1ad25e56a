"""The interface of the panels of the page."""

from typing import Any

from bt_manip.runner import RunEvent


class Panel:
    """A part of the page; its methods are called by the thread of the run.

    Callbacks of its inputs are called by threads of viser: they should only set what the thread of
    the run reads. A panel that raises is not called again; the page and the run go on.

    Attributes:
        in_tab: Whether it has a tab of its own; otherwise it is above the tabs.
    """

    in_tab = True

    def __init__(self, page: Any) -> None:
        """Add the inputs to the current container of viser.

        Args:
            page: The `Page`; ``page.server`` is viser's ``ViserServer`` with ``gui`` and ``scene``.
        """

    def start(self, run: Any) -> None:
        """Prepare for a run, with `.request`, `.station` and `.tree`."""

    def handle(self, event: RunEvent) -> None:
        """Note an event; drawing comes later."""

    def end_tick(self) -> None:
        """Sample the state after a tick, in some microseconds."""

    def draw(self) -> None:
        """Send what has changed to the open pages; called at most ten times a second."""
