"""The simulated robot, as tests see it."""

import itertools
import json
import os
import select
import subprocess
import time
from pathlib import Path

import pytest

SERVER = Path(__file__).with_name("simulated_robot.py")
_SHARED = Path(__file__).resolve().parents[4] / "shared"
MENAGERIE = Path(os.environ.get("MENAGERIE_ROOT", _SHARED / "menagerie"))
_HOSTS = itertools.count(os.getpid() % 200 + 2)


class SimulatedRobot:
    """franka-sim on a loopback address of its own; `ask` does what `simulated_robot.py` can."""

    def __init__(self, model: Path, *options: str, log: Path) -> None:
        python = os.environ.get("FRANKA_SIM_PYTHON")
        if not python:
            pytest.skip("FRANKA_SIM_PYTHON names no Python with franka-sim: see make rehearsal")
        hand = MENAGERIE / "franka_emika_panda" / "hand.xml"
        for path in (model, hand):
            if not path.is_file():
                pytest.skip(f"no model at {path}")
        self.host = f"127.0.0.{next(_HOSTS) % 250 + 2}"
        self._log = log.open("w")
        self._process = subprocess.Popen(
            [python, "-P", str(SERVER), self.host, *options],
            env=os.environ | {"FR3_MJCF": str(model), "FRANKA_HAND_MJCF": str(hand)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
        )
        assert self._line(60.0) == "ready"

    def ask(self, command: str, **arguments):
        """Let the robot do something, and return what it answers."""
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

    def _line(self, seconds: float) -> str:
        stream = self._process.stdout
        if not select.select([stream], [], [], seconds)[0]:
            raise TimeoutError(f"{SERVER.name} says nothing, see {self._log.name}")
        return stream.readline().decode().strip()
