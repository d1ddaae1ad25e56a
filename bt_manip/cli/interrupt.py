"""Ctrl-C, heard at any moment and obeyed in order."""

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

INTERRUPTED = 130
"""Exit code after Ctrl-C: 128 + SIGINT, as a shell has it."""

PATIENCE = 2.0
"""Wall time after which a run that does not stop by itself is stopped [s]."""

ONE_PRESS = 0.1
"""What comes sooner after the first signal is the same one, told twice by what started us [s]."""


class Interrupt:
    """Turns the first Ctrl-C (or SIGTERM) into the end of what is going on.

    What it does depends on what is going on: see `raised`, `held` and `patient`. At first it is
    held, until whoever knows what has to be finished says otherwise. The second one ends a run
    at once, whose arms still brake after the first. Every other one is ignored: it cannot break
    what the first one has to finish.
    """

    def __init__(self) -> None:
        """Begin uninterrupted, without listening yet."""
        self.requested = False
        self.exit_code = 0
        self._mode = "held"
        self._since = 0.0
        self._hurried = False

    def install(self) -> None:
        """Listen to the signals."""
        signal.signal(signal.SIGINT, self._signalled)
        signal.signal(signal.SIGTERM, self._signalled)

    def close(self) -> None:
        """Ignore the signals: what is left to do is to leave."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)

    @contextmanager
    def raised(self) -> Iterator[None]:
        """Raise KeyboardInterrupt where the program is.

        Raises:
            KeyboardInterrupt: Also when the interrupt came before the block.
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
        """Set `requested`, which a run looks at between ticks, so that it ends in order.

        Raises:
            SystemExit: When the block does not end within `PATIENCE` from then on, because a
                plugin hangs; and again, should what follows hang too.
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
        """Have SystemExit raised in the run after each such time; 0 calls it off."""
        if hasattr(signal, "setitimer"):
            signal.signal(signal.SIGALRM, self._out_of_patience)
            signal.setitimer(signal.ITIMER_REAL, after, after)

    def _out_of_patience(self, number: int, frame: FrameType | None) -> None:
        if self._mode == "patient":
            # Not KeyboardInterrupt: what hangs is to be blamed like whatever raises, so that the
            # arm is braked without it.
            raise SystemExit(self.exit_code)
