"""Motions of an arm with random commands at random moments, as rows of 1 ms."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.arm import Arm
from bt_manip.exceptions import MotionError
from bt_manip.robots import Robot, RobotDescription, compile_alone

STEP = 1e-3  # [s]
RANGE = 0.98  # of the joint ranges, in which goals lie
TICKS = 10  # steps between two commands of a servo


class Motion(NamedTuple):
    """A motion from rest to rest.

    Attributes:
        q: Positions [rad].  # (n, nq)
        v: Velocities [rad/s].  # (n, nq)
        a: Accelerations [rad/s2].  # (n, nq)
        commands: What was commanded, in order.
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    commands: tuple[str, ...]


class RandomCommands:
    """Moves an arm from one random configuration to another, disturbed by random commands."""

    def __init__(self, description: RobotDescription) -> None:
        """Build the arm alone; its joints are the first of the model."""
        robot = Robot(description)
        compile_alone(robot)
        self._arm = Arm(robot)
        lower, upper = robot.alone.jnt_range[: len(description.arm_joints)].T
        self._middle, self._half = 0.5 * (lower + upper), 0.5 * (upper - lower)
        self._rows: list[np.ndarray] = []

    def motion(self, seed: int, kind: str = "") -> Motion:
        """Return one motion; each seed has its own.

        Args:
            seed: Seed of everything random.
            kind: The only command, such as ``"turn"``; by default one to three of seven.
        """
        arm, rng = self._arm, np.random.default_rng(seed)
        arm.reset(self._goal(rng))
        self._rows, commands = [self._row()], []
        arm.move_to_configuration(self._goal(rng), speed=float(rng.choice([1.0, 1.0, 0.5])))
        kinds: list[Callable[[np.random.Generator], None]] = [
            self._stop, self._pause, self._scale, self._blend, self._turn, self._servo, self._line,
        ]  # fmt: skip
        chosen = [kinds[i] for i in rng.permutation(len(kinds))[: rng.integers(1, 4)]]
        for command in [getattr(self, f"_{kind}")] if kind else chosen:
            self._advance(rng.uniform(0.05, 0.95) * arm.remaining)
            try:
                command(rng)
            except MotionError:
                continue
            commands.append(command.__name__[1:])
        arm.resume()
        self._advance(60.0)
        q, v, a = np.split(np.array(self._rows), 3, axis=1)
        return Motion(q, v, a, tuple(commands))

    def _goal(self, rng: np.random.Generator) -> np.ndarray:
        """Return a random configuration; in one of three, a joint is near the end of its range."""
        q = rng.uniform(-RANGE, RANGE, len(self._half))
        if rng.random() < 1.0 / 3.0:
            q[rng.integers(len(q))] = rng.choice([-RANGE, RANGE])
        return self._middle + self._half * q

    def _advance(self, duration: float) -> None:
        """Advance by a time [s], at most to rest."""
        for _ in range(int(duration / STEP)):
            if not self._arm.moving:
                return
            self._arm.advance(STEP)
            self._rows.append(self._row())

    def _row(self) -> np.ndarray:
        return np.concatenate([self._arm.q, self._arm.v, self._arm.a])

    def _stop(self, rng: np.random.Generator) -> None:
        self._arm.stop()
        self._advance(rng.uniform(0.0, 0.3))
        self._arm.move_to_configuration(self._goal(rng))

    def _pause(self, rng: np.random.Generator) -> None:
        self._arm.pause()
        self._advance(rng.uniform(0.0, 0.5))
        self._arm.resume()

    def _scale(self, rng: np.random.Generator) -> None:
        for scale in rng.uniform(0.1, 1.0, 3):
            self._arm.speed_scale = float(scale)
            self._advance(rng.uniform(0.0, 0.3))
        self._arm.resume()

    def _segment(self, rng: np.random.Generator) -> None:
        """Let the motion go on."""

    def _back(self, rng: np.random.Generator) -> None:
        self._arm.back_off(rng.uniform(0.05, 0.3))

    def _follow(self, rng: np.random.Generator) -> None:
        T = self._arm.model.pose(self._arm.target).copy()
        for _ in range(10):
            T.translation += rng.uniform(-0.05, 0.05, 3)
            self._arm.follow(T)
            self._advance(0.1)

    def _blend(self, rng: np.random.Generator) -> None:
        self._arm.blend_radius = 0.2
        self._arm.move_to_configuration(self._goal(rng))

    def _turn(self, rng: np.random.Generator) -> None:
        self._arm.move_to_configuration(self._goal(rng))

    def _servo(self, rng: np.random.Generator) -> None:
        arm, goal, speed = self._arm, self._goal(rng), rng.uniform(0.2, 1.0)
        if rng.random() < 0.5:
            arm.stop()
            self._advance(60.0)
        target, duration = arm.q_ref, 2 * TICKS * STEP
        for _ in range(80):
            step = speed * arm.model.limits.velocity * TICKS * STEP
            target = target + np.clip(goal - target, -step, step)
            arm.servo(target, np.zeros_like(target), duration)
            self._advance(TICKS * STEP)

    def _line(self, rng: np.random.Generator) -> None:
        self._arm.stop()
        self._advance(60.0)
        T = self._arm.model.pose(self._arm.q_ref)
        beside = T.translation + rng.uniform(-0.15, 0.15, 3)
        self._arm.move_linear(pin.SE3(T.rotation.copy(), beside))
