"""A program that believes to be in front of a person."""

import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest


class Terminal:
    """A program that believes to be in front of a person."""

    def __init__(self, *command: str, cwd: Path, **more: str) -> None:
        self.shown = b""
        self._own, theirs = pty.openpty()
        environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100", "LINES": "40", **more}
        self._process = subprocess.Popen(
            command, stdin=theirs, stdout=theirs, stderr=theirs, cwd=cwd, env=environment
        )
        os.close(theirs)

    def wait_for(self, pattern: bytes) -> None:
        """Wait until a regular expression is found in what was shown."""
        deadline = time.monotonic() + 60.0  # [s] of a hopeless wait, not of a passing test
        while not re.search(pattern, self.shown):
            if time.monotonic() > deadline or not self._read():
                raise AssertionError(f"{pattern!r} never came:\n{self.shown.decode()}")

    def interrupt(self) -> None:
        self._process.send_signal(signal.SIGINT)

    def hang_up(self, number: int) -> int:
        os.close(self._own)
        self._process.send_signal(number)
        return self._process.wait(30)

    def kill(self) -> None:
        self._process.kill()
        self._process.wait(30)

    def end(self) -> int:
        while self._read():
            pass
        os.close(self._own)
        return self._process.wait(30)

    def _read(self) -> bool:
        ready, _, _ = select.select([self._own], [], [], 60)
        try:
            data = os.read(self._own, 65536) if ready else b""
        except OSError:  # the other end is closed
            data = b""
        self.shown += data
        return bool(data)


@pytest.fixture
def terminal(tmp_path) -> Iterator[Callable[..., Terminal]]:
    """Start the program at a terminal; keywords are environment variables."""
    started: list[Terminal] = []

    def start(*arguments: str, **environment: str) -> Terminal:
        command = (sys.executable, "-m", "bt_manip", *arguments)
        started.append(Terminal(*command, cwd=tmp_path, **environment))
        return started[-1]

    yield start
    for each in started:
        each.kill()
