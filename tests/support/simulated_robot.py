"""Simulators of robots by others, as tests see them: processes that lines of JSON drive."""

import itertools
import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

SERVING = Path(__file__).with_name("simulator")
_HOSTS = itertools.count(os.getpid() % 200 + 2)


class SimulatedRobot:
    """A simulator on a loopback address of its own; `ask` does what its script can.

    Args:
        script: It is called with the address and the options, in the simulator's environment, and
            ends in `serving.serve`.
        python: Environment variable that names the Python of this environment.
        log: File for its messages.
        options: More arguments of the script.
        variables: More environment variables.
    """

    def __init__(
        self,
        script: Path,
        python: str,
        log: Path,
        *options: str | Path,
        variables: Mapping[str, str] | None = None,
    ) -> None:
        if not os.environ.get(python):
            pytest.skip(f"{python} names no Python with the simulator: see make rehearsal")
        self.host = f"127.0.0.{next(_HOSTS) % 250 + 2}"
        self._script, self._log = script, log.open("w")
        self._process = subprocess.Popen(
            [os.environ[python], "-P", str(script), self.host, *map(str, options)],
            env=os.environ | {"PYTHONPATH": str(SERVING)} | dict(variables or {}),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
        )
        assert self._line(60.0) == "ready"

    def ask(self, command: str, **arguments: Any) -> Any:
        """Let the robot do something, and return what it answers."""
        line = json.dumps({"do": command, **arguments})
        assert self._process.stdin is not None
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()
        answer = json.loads(self._line(15.0))
        assert "error" not in answer, answer
        return answer["ok"]

    def until(self, condition: Callable[[dict[str, Any]], bool], seconds: float = 10.0) -> None:
        """Wait until something is true of the arm."""
        end = time.monotonic() + seconds
        while not condition(self.ask("arm")):
            assert time.monotonic() < end
            time.sleep(0.02)

    def end(self) -> None:
        """End the process, and print its last messages."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._log.close()
        print(Path(self._log.name).read_text()[-3000:], file=sys.stderr)

    def _line(self, seconds: float) -> str:
        stream = self._process.stdout
        assert stream is not None
        if not select.select([stream], [], [], seconds)[0]:
            raise TimeoutError(f"{self._script.name} says nothing, see {self._log.name}")
        return stream.readline().decode().strip()
