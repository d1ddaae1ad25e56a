"""Motions of an arm with random commands at random moments, as rows of 1 ms."""

from math import inf
from typing import NamedTuple

import numpy as np

from bt_manip.robots import Robot, RobotDescription, compile_alone

from .requests import Trial

COMMANDS = ("stop", "pause", "scale", "blend", "turn", "servo", "line")


class Motion(NamedTuple):
    """A motion from rest to rest."""

    q: np.ndarray  # [rad]  (n, nq)
    v: np.ndarray  # [rad/s]  (n, nq)
    a: np.ndarray  # [rad/s2]  (n, nq)
    commands: tuple[str, ...]  # in order


class RandomCommands:
    """Moves an arm from one random configuration to another, disturbed by random commands."""

    def __init__(self, description: RobotDescription) -> None:
        self._robot = Robot(description)
        compile_alone(self._robot)

    def motion(self, seed: int) -> Motion:
        """Return one motion with one to three of seven commands; each seed has its own."""
        trial = Trial(self._robot, seed, inf, boxed=False)
        trial.request("turn", 0.0)
        commands = tuple(trial.rng.permutation(COMMANDS)[: trial.rng.integers(1, 4)].tolist())
        for command in commands:
            trial.request(command, trial.rng.uniform(0.05, 0.95))
            trial.arm.resume()  # at full speed
        trial.finish()
        v, a = np.array(trial.rates).transpose(1, 0, 2)
        return Motion(np.array(trial.rows), v, a, commands)
