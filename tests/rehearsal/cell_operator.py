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
from typing import Any

import numpy as np
from real_cell import RealCell

from bt_manip import spatial

SPEED = 0.5
SETTLE = 2.0  # [s] of wall time in which an object in the basket comes to rest
ASKED = re.compile(r"(Put|Take) '(\w+)'")


class Operator:
    """Runs ``bt-manip run`` on a simulated robot, and does what it asks for.

    Args:
        robot: The simulated robot.
        scene: The scene file.
        cell: What the simulated cell has.
        options: More options of the command.
        cycles: Cycles of the tree.
        names: Names of the robot and of its backend.
        task: Names of the tree and of the source of poses.
    """

    def __init__(
        self,
        robot: Any,
        scene: Path,
        cell: RealCell,
        *options: str,
        cycles: int = 1,
        names: tuple[str, str] = ("fr3", "franka"),
        task: tuple[str, str] = ("pick_place", "operator"),
    ) -> None:
        """Start the process."""
        self._robot, self._cell = robot, cell
        self.before_answer: Callable[[], object] = lambda: None  # when an object is in its place
        self.placed: list[str] = []  # that lay in the simulated basket when they were taken away
        self.output = ""
        command = [
            sys.executable, "-m", "bt_manip", "run", task[0], "--robot", names[0],
            "--scene", str(scene), "--backend", f"{names[1]}={robot.host}", "--poses", task[1],
            "--cycles", str(cycles), "--speed", str(SPEED), *options,
        ]  # fmt: skip
        self.process = subprocess.Popen(
            command, bufsize=0, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
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
            if asked := ASKED.match(line):
                (self.put if asked[1] == "Put" else self.take)(asked[2])
        return self.output

    def rest(self) -> str:
        """End the process; return all that it has printed."""
        self.process.kill()
        return self.output + self.process.stdout.read().decode()

    def end(self, seconds: float = 120.0) -> int:
        """Answer until the process has ended; return its exit code."""
        self.until("", seconds)
        return self.process.wait(20.0)

    def take(self, name: str) -> None:
        """Take an object away, and note whether it lay in the basket."""
        if in_basket(self._robot, self._cell, name):
            self.placed.append(name)
        self._robot.ask("take", body=name)

    def put(self, name: str) -> None:
        """Put an object where the scene says, and confirm it."""
        pose = self._cell.objects[name]
        quat = spatial.quat_wxyz(pose).tolist()
        self._robot.ask("place", body=name, position=pose.translation.tolist(), quat=quat)
        self.before_answer()
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.write(b"\n")
            self.process.stdin.flush()


def in_basket(robot: Any, cell: RealCell, name: str) -> bool:
    """Judge by the simulated robot's own state whether an object lies in the basket."""
    end = time.monotonic() + SETTLE
    while (found := robot.ask("poses")[name])["speed"] > 0.1 and time.monotonic() < end:
        time.sleep(0.05)
    x, y, z = cell.basket.actInv(np.array(found["position"]))
    return bool(abs(x) < 0.105 and abs(y) < 0.067 and 0.0 < z < 0.1 and found["speed"] <= 0.1)
