"""The handler of Ctrl-C, as in the program."""

import signal

import pytest

from bt_manip.cli import Interrupt

SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGXCPU")


@pytest.fixture
def interrupt():
    """Handle signals as the program does."""
    interrupt, handlers = Interrupt(), {}
    for name in SIGNALS:
        handlers[getattr(signal, name)] = signal.getsignal(getattr(signal, name))
    interrupt.install()
    yield interrupt
    for number, handler in handlers.items():
        signal.signal(number, handler)
