"""bt-manip in a process of its own, with an operator who puts objects where it asks for them."""

import contextlib
import os
import re
import select
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from real_cell import RealCell
from simulation import SimulatedRobot

from bt_manip import spatial

SPEED = 0.5
LINE = re.compile(r"Put '(\w+)'")


class Operator:
    """Runs ``bt-manip run`` on a simulated robot, and answers what it asks."""

    def __init__(
        self, robot: SimulatedRobot, scene: Path, cell: RealCell, *options: str, cycles: int = 1
    ) -> None:
        """Start the process."""
        self._robot, self._cell = robot, cell
        self.before_answer: Callable[[], object] = lambda: None
        self.output = ""
        command = [
            sys.executable, "-m", "bt_manip", "run", "pick_place", "--robot", "fr3",
            "--scene", str(scene), "--backend", f"franka={robot.host}", "--poses", "operator",
            "--cycles", str(cycles), "--speed", str(SPEED), *options,
        ]  # fmt: skip
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            env=os.environ | {"PYTHONUNBUFFERED": "1"},
        )  # fmt: skip

    def until(self, found: str = "", seconds: float = 120.0) -> str:
        """Answer until the output has a text, or has ended; return the output."""
        end, stream = time.monotonic() + seconds, self.process.stdout
        while not found or not re.search(found, " ".join(self.output.split())):
            left = end - time.monotonic()
            if left < 0.0 or not select.select([stream], [], [], left)[0]:
                raise TimeoutError(f"no {found!r} within {seconds:g} s in:\n{self.output}")
            line = stream.readline().decode()
            if not line:
                break
            self.output += line
            if asked := LINE.match(line):
                self._put(asked[1])
        return self.output

    def end(self, seconds: float = 120.0) -> int:
        """Answer until the process has ended; return its exit code."""
        self.until("", seconds)
        return self.process.wait(20.0)

    def _put(self, name: str) -> None:
        pose = self._cell.objects[name]
        quat = spatial.quat_wxyz(pose).tolist()
        self._robot.ask("place", body=name, position=pose.translation.tolist(), quat=quat)
        self.before_answer()
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.write(b"\n")
            self.process.stdin.flush()


def in_basket(robot: SimulatedRobot, cell: RealCell) -> list[str]:
    """Judge by the simulated robot's own state which objects lie in the basket."""
    inside = []
    for name, found in robot.ask("poses").items():
        x, y, z = cell.basket.actInv(np.array(found["position"]))
        if abs(x) < 0.105 and abs(y) < 0.067 and 0.0 < z < 0.16:
            inside.append(name)
    return inside
