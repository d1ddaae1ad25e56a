"""Random requests to any arm, and a judge of what it did by its positions at control steps."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.arm import Arm
from bt_manip.exceptions import MotionError
from bt_manip.planning import ArcTo, LineTo
from bt_manip.robots import Robot
from tests.measuring.stops import distance

STEP = 1e-3  # [s]
REASONS = {"target", "unreachable", "line", "effort", "limits"}
REQUESTS = (
    "turn", "pose", "line", "path", "blend", "servo", "follow", "back", "stop", "pause", "scale",
)  # fmt: skip
LONGEST = 600.0  # [s] of a motion


class Goal(NamedTuple):
    """Where the last accepted request leads: to a configuration [rad], or to a tool pose."""

    q: np.ndarray | None = None
    T_wt: pin.SE3 | None = None


class Trial:
    """An arm that gets random requests at random moments.

    Args:
        robot: A compiled robot; its first joints are those of the arm.
        seed: Seed of everything random.
        tool_speed: Limit of the speed of its tool [m/s].
        boxed: Whether its tool has to stay in a box around its first position.

    Attributes:
        rows: Its positions at control steps [rad].
        rates: Its velocities [rad/s] and accelerations [rad/s2] then.
        goal: Where it shall come to rest; None where no request says it.
        refused: Reasons of refused requests.
        off_path: Largest distance of a stop from the path [rad].
    """

    def __init__(self, robot: Robot, seed: int, tool_speed: float, boxed: bool) -> None:
        self.robot, self.rng = robot, np.random.default_rng(seed)
        self._mj_data = mujoco.MjData(robot.mj_model)
        start = self._configuration()
        self.box = np.array([[-np.inf] * 3, [np.inf] * 3])
        if boxed:
            sizes = self.rng.uniform(0.1, 0.8, (2, 3)) * [[-1.0], [1.0]]
            self.box = self.tool_pose(start).translation + sizes
        robot.limits = replace(robot.limits, tool_speed=tool_speed, box=self.box if boxed else None)
        robot.set_configuration(start)
        self.arm = Arm(robot)
        self.rows, self.rates = [self.arm.q_ref], [(self.arm.v.copy(), self.arm.a.copy())]
        self.goal: Goal | None = None
        self.refused: list[str] = []
        self.off_path = 0.0

    def request(self, kind: str, share: float) -> None:
        """Make requests of a kind after a share of the rest of the motion."""
        self.advance(share * self.arm.remaining)
        getattr(self, f"_{kind}")()

    def _ask(self, method: Callable[..., None], *arguments: Any, goal: Goal | None = None) -> bool:
        """Make a request; return whether it was accepted. A refused one changes nothing."""
        before = self.arm.get_state()
        try:
            method(*arguments)
        except MotionError as error:
            assert error.reason in REASONS and str(error)
            assert self.arm.get_state() == before
            self.refused.append(error.reason)
            return False
        self.goal = goal
        return True

    def finish(self) -> None:
        """Let the motion end."""
        self.arm.resume()
        self.advance(LONGEST)
        assert not self.arm.busy

    def advance(self, duration: float) -> None:
        """Advance by a time [s], at most to rest."""
        for _ in range(int(duration / STEP)):
            if not self.arm.moving:
                return
            self.arm.advance(STEP)
            self.rows.append(self.arm.q_ref)
            self.rates.append((self.arm.v.copy(), self.arm.a.copy()))

    def tool_pose(self, q: np.ndarray) -> pin.SE3:
        """Return the pose of the tool in the world, by MuJoCo."""
        robot, data = self.robot, self._mj_data
        data.qpos[robot.qpos_adr] = q
        mujoco.mj_kinematics(robot.mj_model, data)
        site = robot.tool_site_id
        return pin.SE3(data.site_xmat[site].reshape(3, 3).copy(), data.site_xpos[site].copy())

    # Requests

    def _turn(self) -> None:
        q = self._configuration()
        self._ask(self.arm.move_to_configuration, q, self._speed(), goal=Goal(q=q))

    def _pose(self) -> None:
        T = self.tool_pose(self._configuration())
        self._ask(self.arm.move_to_pose, T, self._speed(), goal=Goal(T_wt=T))

    def _line(self) -> None:
        T = self._beside()
        self._ask(self.arm.move_linear, T, self._speed(), goal=Goal(T_wt=T))

    def _path(self) -> None:
        first, last = self._beside(), self._beside()
        via = 0.5 * (first.translation + last.translation) + self.rng.uniform(-0.1, 0.1, 3)
        move = partial(self.arm.move_path, blend=float(self.rng.choice([0.0, 0.02])))
        self._ask(move, [LineTo(first), ArcTo(via, last)], self._speed(), goal=Goal(T_wt=last))

    def _blend(self) -> None:
        radius = self.rng.uniform(0.05, 0.4)
        while self.arm.moving and not self.arm.ends_within(radius):
            self.advance(10 * STEP)
        self.arm.blend_radius = radius
        self.rng.choice([self._line, self._turn])()

    def _servo(self) -> None:
        arm, goal, speed = self.arm, self._configuration(), self.rng.uniform(0.2, 1.0)
        target, ticks = arm.q_ref, int(self.rng.integers(5, 30))
        for _ in range(int(self.rng.integers(1, 40))):
            step = speed * arm.model.limits.velocity * ticks * STEP
            move = np.clip(goal - target, -step, step)
            target = target + move
            self._ask(arm.servo, target, move / (ticks * STEP), 2 * ticks * STEP)
            self.advance(ticks * STEP)

    def _follow(self) -> None:
        T = self.tool_pose(self.arm.target)
        for _ in range(5):
            T.translation += self.rng.uniform(-0.05, 0.05, 3)
            self._ask(self.arm.follow, T, self._speed())
            self.advance(0.1)

    def _back(self) -> None:
        self._ask(self.arm.back_off, self.rng.uniform(0.02, 0.3), self._speed())

    def _stop(self) -> None:
        self._check_stop(self.arm.stop)
        self.goal = None

    def _pause(self) -> None:
        self._check_stop(self.arm.pause)
        self.arm.resume()

    def _scale(self) -> None:
        for scale in self.rng.uniform(0.05, 1.0, 3):
            self.arm.speed_scale = float(scale)
            self.advance(self.rng.uniform(0.0, 0.3))

    def _check_stop(self, stop: Callable[[], None]) -> None:
        """Stop, and compare the positions with those of the motion that goes on."""
        arm = self.arm
        other = Arm(self.robot, model=arm.model, ik=arm.ik)
        other.set_state(arm.get_state())
        path = [other.q_ref]
        while other.moving:
            other.advance(STEP)
            path.append(other.q_ref)
        begin = len(self.rows)
        stop()
        self.advance(self.rng.choice([0.05, LONGEST]))
        stopped = self.rows[begin:]
        self.off_path = max((distance(np.array(path), q) for q in stopped), default=self.off_path)

    def _speed(self) -> float:
        return float(self.rng.choice([1.0, 1.0, 0.5]))

    def _configuration(self) -> np.ndarray:
        """Return a random configuration; in one of three, a joint is at the end of its range."""
        limits, rng = self.robot.limits, self.rng
        lower, upper = limits.sampling_bounds()
        q = rng.uniform(lower, upper)
        if rng.random() < 1.0 / 3.0:
            joint = rng.integers(len(q))
            q[joint] = (lower if rng.random() < 0.5 else upper)[joint]
        return q

    def _beside(self) -> pin.SE3:
        """Return a pose beside the one where the arm comes to rest."""
        T = self.tool_pose(self.arm.target)
        turned = T.rotation @ pin.exp3(self.rng.uniform(-0.3, 0.3, 3))
        return pin.SE3(turned, T.translation + self.rng.uniform(-0.15, 0.15, 3))
