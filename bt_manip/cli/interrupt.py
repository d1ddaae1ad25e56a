"""Handling of Ctrl-C and of other signals that ask the program to end."""

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from bt_manip.cli.exit_codes import SUCCESS

PATIENCE = 2.0
"""Wall time after which a run that does not stop after the signal is aborted [s]."""

ONE_PRESS = 0.1
"""Signals within this time of the first are duplicates of it, sent by a parent process [s]."""


SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU")
"""Signals that end the program in order: Ctrl-C, kill, a closed terminal, a limit of CPU time."""


class Interrupt:
    """Ends the program in order after one of the `SIGNALS`.

    The effect of the first signal depends on the mode: see `raised`, `held` (the initial mode) and
    `patient`. A second signal aborts a run that is stopping its arms. Further signals are ignored,
    so that they cannot break what is being written.
    """

    def __init__(self) -> None:
        self.requested = False
        self.exit_code = SUCCESS
        self._mode = "held"
        self._since = 0.0
        self._hurried = False

    def install(self) -> None:
        """Handle the signals from now on."""
        for number in self._numbers():
            signal.signal(number, self._signalled)

    def close(self) -> None:
        """Ignore the signals while the process exits."""
        for number in self._numbers():
            signal.signal(number, signal.SIG_IGN)

    @staticmethod
    def _numbers() -> list[signal.Signals]:
        """Return the signals that this system has; SIGHUP stays ignored where nohup ignores it."""
        numbers = [getattr(signal, name) for name in SIGNALS if hasattr(signal, name)]
        ignored = signal.SIG_IGN
        return [n for n in numbers if n.name != "SIGHUP" or signal.getsignal(n) is not ignored]

    @contextmanager
    def raised(self) -> Iterator[None]:
        """Raise KeyboardInterrupt at the signal.

        Raises:
            KeyboardInterrupt: Also if the signal came before the block.
        """
        with self._in_mode("raised"):
            if self.requested:
                raise KeyboardInterrupt
            yield

    @contextmanager
    def held(self) -> Iterator[None]:
        """Only set `requested`."""
        with self._in_mode("held"):
            yield

    @contextmanager
    def patient(self) -> Iterator[None]:
        """Set `requested`, which a run checks between ticks, so that it stops its arms and ends.

        Raises:
            SystemExit: If the block does not end within `PATIENCE` of the signal, because a plugin
                hangs; repeated after the same time.
            KeyboardInterrupt: At the second signal.
        """
        try:
            with self._in_mode("patient"):
                yield
        finally:
            self._alarm(0.0)

    @contextmanager
    def _in_mode(self, mode: str) -> Iterator[None]:
        before, self._mode = self._mode, mode
        try:
            yield
        finally:
            self._mode = before

    def _signalled(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if self.requested:
            if number == getattr(signal, "SIGXCPU", None):  # repeated every second
                return
            if self._mode == "patient" and not self._hurried and now - self._since > ONE_PRESS:
                self._hurried = True
                raise KeyboardInterrupt
            return
        self.requested, self._since = True, now
        self.exit_code = 128 + number
        if self._mode == "raised":
            raise KeyboardInterrupt
        if self._mode == "patient":
            self._alarm(PATIENCE)

    def _alarm(self, after: float) -> None:
        """Raise SystemExit in the run after this time, repeatedly; 0 cancels it."""
        if hasattr(signal, "setitimer"):
            signal.signal(signal.SIGALRM, self._out_of_patience)
            signal.setitimer(signal.ITIMER_REAL, after, after)

    def _out_of_patience(self, number: int, frame: FrameType | None) -> None:
        if self._mode == "patient":
            # Not KeyboardInterrupt: a behaviour that hangs is reported like one that raises, and
            # the arms are stopped without it.
            raise SystemExit(self.exit_code)
