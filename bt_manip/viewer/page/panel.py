"""The interface of the panels of the page."""

from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

import numpy as np

from bt_manip.runner import Run, RunEvent, Station

HANDLE_SIZE = 0.15
"""Length of the arrows of a handle in the scene [m]."""


class Panel:
    """A part of the page; its methods are called by the thread of the run.

    It shows events and samples, which are those of a run or of a recording. Where a recording goes
    back to an earlier time, `reset` is called, and all events up to that time follow again.

    Callbacks of its inputs are called by the thread of the server: they should only set what the
    thread of the run reads. A panel that raises is not called again; the page and the run go on.

    Args:
        page: The `Page`: ``page.gui`` is the `Gui` that adds inputs, and ``page.server.scene``
            adds things to the scene, which viser draws.

    Attributes:
        place: ``tab`` for a tab of its own, ``left`` beside the scene, ``below``
            or ``over`` it, or ``bar``.
        needs_run: Whether it is left out on the page of a recording, where `start` and `end_tick`
            are not called.
    """

    place = "tab"
    needs_run = False

    def __init__(self, page: Any) -> None:
        pass

    def start(self, run: Run) -> None:
        """Prepare for a run, with `.request`, `.station` and `.tree`."""

    def reset(self) -> None:
        """Forget all events and samples: those that follow begin at the start of a run."""

    def begin_idle(self, station: Station) -> None:
        """Prepare for the time until the next run, in a cell that may be another one."""

    def idle_tick(self) -> None:
        """Act on requests before a tick between runs."""

    def handle(self, event: RunEvent) -> None:
        """Note an event; drawing comes later."""

    def sample(
        self, times: np.ndarray, joints: Mapping[str, tuple[np.ndarray, np.ndarray]]
    ) -> None:
        """Note the states after one or several ticks; those of a run come before it is drawn.

        Args:
            times: Simulated times [s].  # (n,)
            joints: Positions and references of the joints of each robot [rad].  # (n, nq) each
        """

    def end_tick(self) -> None:
        """Act after a tick of a run."""

    def show_recording(self, events: Iterable[RunEvent], start: float, end: float) -> None:
        """Take a whole recording before one of its times is shown.

        Args:
            events: All its events.
            start: Simulated time at its start [s].
            end: At its end [s].
        """

    def draw(self) -> None:
        """Send changes to the open pages; called at most ten times a second."""

    def close(self) -> None:
        """Free resources; the page is closed."""


def message_html(message: str, *, error: bool = False) -> str:
    """Return a message as HTML; empty where there is none."""
    return message and f'<div class="{"error" if error else "note"}">{escape(message)}</div>'
