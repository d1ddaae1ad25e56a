"""The simulated arm, as tests see it."""

import itertools
import json
import os
import select
import subprocess
import sys
import time
from pathlib import Path

import pytest

SERVER = Path(__file__).with_name("simulated_widowx.py")
_HOSTS = itertools.count(os.getpid() % 200 + 2)


class SimulatedWidowX:
    """trossen-arm-sim on a loopback address of its own; `ask` does what `simulated_widowx.py` can.

    Args:
        log: File for its messages.
        model: The cell; by default the arm alone.
    """

    def __init__(self, log: Path, *model: Path) -> None:
        python = os.environ.get("TROSSEN_SIM_PYTHON")
        if not python:
            pytest.skip("TROSSEN_SIM_PYTHON names no Python with trossen-arm-sim: make rehearsal")
        self.host = f"127.0.0.{next(_HOSTS) % 250 + 2}"
        self._log = log.open("w")
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        self._process = subprocess.Popen(
            [python, "-P", str(SERVER), self.host, *map(str, model)],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
        )
        assert self._line(60.0) == "ready"

    def ask(self, command: str, **arguments):
        """Let the arm do something, and return what it answers."""
        line = json.dumps({"do": command, **arguments})
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()
        answer = json.loads(self._line(15.0))
        assert "error" not in answer, answer
        return answer["ok"]

    def until(self, condition, seconds: float = 10.0) -> None:
        """Wait until something is true of the arm."""
        end = time.monotonic() + seconds
        while not condition(self.ask("arm")):
            assert time.monotonic() < end
            time.sleep(0.02)

    def end(self) -> None:
        """End the process."""
        self._process.stdin.close()
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
        self._log.close()
        print(Path(self._log.name).read_text()[-3000:], file=sys.stderr)

    def _line(self, seconds: float) -> str:
        stream = self._process.stdout
        if not select.select([stream], [], [], seconds)[0]:
            raise TimeoutError(f"{SERVER.name} says nothing, see {self._log.name}")
        return stream.readline().decode().strip()
