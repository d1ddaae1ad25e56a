"""What the tests share: drawing, runs in stations of their own, and the program."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cached_property
from pathlib import Path

import pytest

from tests.support.drawing import opengl as opengl
from tests.support.drawing import (
    processes_draw_if_their_test_does as processes_draw_if_their_test_does,
)
from tests.support.program import bt_manip as bt_manip
from tests.support.program import task as task
from tests.support.program import trees as trees
from tests.support.runs import make_run as make_run
from tests.support.runs import picked as picked
from tests.support.runs import shared_stations as shared_stations
from tests.support.runs import station_pool as station_pool


@pytest.fixture(autouse=True)
def tests_share_stations(shared_stations) -> None:
    """Let runs have the stations of the tests before."""


PATIENCE = 90.0
"""Longest wait for anything, on a loaded computer [s]: not that of a passing test."""


class Program:
    """``bt-manip`` in a process of its own, which serves pages."""

    def __init__(self, folder: Path, *arguments: object) -> None:
        self.errors = folder / "stderr.txt"
        with self.errors.open("wb") as errors:
            self.process = subprocess.Popen(
                [sys.executable, "-u", "-m", "bt_manip", *map(str, arguments)],
                stdout=subprocess.PIPE, stderr=errors, text=True, cwd=folder,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            )  # fmt: skip
        self.shown = ""

    @cached_property
    def url(self) -> str:
        """The address of its page, once it says it."""
        return self.wait_for(r"http://[\d.]+:\d+")

    def wait_for(self, pattern: str) -> str:
        """Return the first text on standard output that matches, waiting for it."""
        assert self.process.stdout is not None
        while (found := re.search(pattern, self.shown)) is None:
            line = self.process.stdout.readline()
            assert line, f"{self.shown}\n{self.errors.read_text()}"
            self.shown += line
        return found[0]

    def interrupt(self) -> int:
        """Press Ctrl-C and return the exit code."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(PATIENCE)

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()


@pytest.fixture(scope="module")
def start(tmp_path_factory) -> Iterator[Callable[..., Program]]:
    """Give a function that starts ``bt-manip`` with some arguments."""
    programs: list[Program] = []

    def start(*arguments: object) -> Program:
        programs.append(Program(tmp_path_factory.mktemp("program"), *arguments))
        return programs[-1]

    yield start
    for program in programs:
        program.close()
        assert not program.errors.read_text()
