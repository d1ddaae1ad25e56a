"""Interface of the panels of the page."""

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np

from bt_manip.runner import Run, RunEvent, Station

HANDLE_SIZE = 0.15
"""Length of the arrows of handles in the scene [m]."""


class Panel:
    """A part of the page; its methods are called by the thread of the run.

    It shows events and samples of a run or of a recording. When the page shows an earlier time,
    `reset` is called, then all events up to that time follow.

    Callbacks of its inputs are called by the thread of the server; they should only set attributes
    for the thread of the run. A panel that raises is not called again; page and run continue.

    Args:
        page: The `Page`: ``page.gui`` is the `Gui` that adds inputs, and ``page.server.scene``
            adds things to the scene, which viser draws.

    Attributes:
        place: ``tab`` for its own tab, ``left`` of the scene, ``below`` or ``over`` it, or ``bar``.
        needs_run: Whether it needs `start` and `end_tick`, which the page of a recording does not
            call: it is left out there, and shows the present where others show the past.
        whole_run: Whether it gets the events of the whole run, whatever time the page shows.
    """

    place = "tab"
    needs_run = False
    whole_run = False

    def __init__(self, page: Any) -> None:
        pass

    def start(self, run: Run) -> None:
        """Prepare for a run, with `.request`, `.station` and `.tree`."""

    def reset(self) -> None:
        """Discard all events and samples; new ones follow from the start of a run."""

    def begin_idle(self, station: Station) -> None:
        """Prepare for the time until the next run, perhaps in another cell."""

    def idle_tick(self) -> None:
        """Process requests before a tick between runs."""

    def handle(self, event: RunEvent) -> None:
        """Store an event, for `draw`."""

    def sample(
        self, times: np.ndarray, joints: Mapping[str, tuple[np.ndarray, np.ndarray]]
    ) -> None:
        """Store the states after one or more ticks, for `draw`.

        Args:
            times: Simulated times [s].  # (n,)
            joints: Positions and references of the joints of each robot [rad].  # (n, nq) each
        """

    def end_tick(self) -> None:
        """Process requests after a tick of a run."""

    def draw(self) -> None:
        """Send changes to the open pages; called at most ten times a second."""

    def close(self) -> None:
        """Free resources when the page is closed."""


def message_html(message: str, *, error: bool = False) -> str:
    """Return a message as HTML; empty for an empty message."""
    return message and f'<div class="{"error" if error else "note"}">{escape(message)}</div>'
