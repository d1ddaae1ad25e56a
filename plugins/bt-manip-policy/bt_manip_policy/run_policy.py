"""Run a learned policy."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from bt_manip.arm import Arm
from bt_manip.behaviours import ArmBehaviour
from bt_manip.bt import Input, Status
from bt_manip.episodes import (
    Observations,
    command_gripper,
    differential_ik,
    displaced,
    end_velocity,
    held_payload,
)
from bt_manip.exceptions import PortError, did_you_mean

from .onnx_policy import OnnxPolicy, PolicyError

T = TypeVar("T")

OBJECT = "object_"
"""Beginning of the names of observations of the object that the port ``object`` names."""


class RunPolicy(ArmBehaviour):
    """Let a learned policy act until something else halts it, or fail after a time.

    Each action goes to the arm as `Arm.servo`: it keeps all limits, and the arm stops by itself on
    an external force. A halted policy leaves the arm at rest. Actions of environments move along
    cubics instead (`bt_manip.episodes`), which repeat recorded targets but keep fewer limits.
    """

    model = Input(str, doc="ONNX file of the policy.")
    object = Input(str, default="", doc="Name of the object that the policy observes as 'object'.")
    time_limit = Input(float, default=10.0, doc="Simulated time after which it fails [s].")

    amounts: ClassVar = {"time_limit": "s"}
    memory = (*ArmBehaviour.memory, "_time", "_motion", "_action", "_next")

    _policy: OnnxPolicy | None = None
    _observations: Observations | None = None
    _time = 0.0  # [s] simulated, of the present action
    _motion: Sequence[Sequence[float]] | None = None  # [rad] last target, and its change to there
    _action: Sequence[float] = ()  # the present one
    _next: Sequence[Sequence[float]] = ()  # those that follow it without a new observation

    def setup(self, **infrastructure: Any) -> None:
        """Read the policy, if it is known already.

        Raises:
            PolicyError: If it is no policy.
        """
        super().setup(**infrastructure)
        try:
            self._load()
        except PortError:  # the entry is written later
            return

    def start(self) -> None:
        """Take the first action."""
        self._load()
        self._observations = None
        self._motion, self._next, self._time = None, (), self.cell.time
        self._act()

    def update(self) -> Status:
        """Act when it is time, until the time limit."""
        arm, now, step = self.arm, self.cell.time, 1.0 / self._load().rate
        if arm.fault:
            return self.fail(arm.fault)
        if self.elapsed >= self.time_limit - 1e-9:
            return self.fail(f"the policy has not been halted for {self.time_limit:g} s")
        if arm.paused:
            self._time = now
            self.feedback_message = "paused"
            return Status.RUNNING
        due = self._time + step
        if now >= due + step - 1e-9:
            return self.fail(f"the policy acts every {1e3 * step:g} ms and is ticked less often")
        if now >= due - 1e-9:
            self._time = due
            self._act()
        self._grip(step)
        self.feedback_message = f"{self.elapsed:.2f} s"
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stop arm and gripper; a held object stays held."""
        if self.arm.busy and not self.arm.fault:
            self.arm.stop()
        self.stop_gripper()

    def _load(self) -> OnnxPolicy:
        """Return the policy that the port names.

        Raises:
            PolicyError: If it is no policy.
        """
        path = Path(self.model)
        if self._policy is None or self._policy.path != path:
            self._policy = OnnxPolicy(path)
        return self._policy

    def _act(self) -> None:
        """Command the next action.

        Raises:
            PolicyError: If the policy does not fit the station, or returns no valid action.
            MotionError: If the arm cannot move now.
        """
        policy, arm = self._load(), self.arm
        if policy.action not in ACTIONS:
            raise PolicyError(
                f"policy '{policy.path}' has actions '{policy.action}'"
                + did_you_mean(policy.action, ACTIONS)
            )
        kind = ACTIONS[policy.action]
        n = kind.size(arm)
        gripper = self._robots[self._robot_name].gripper
        if not self._next:
            size = n + (gripper is not None)
            self._next = policy.act(self._observe(policy), size).tolist()
        self._action, *self._next = self._next
        last, change = self._motion or (arm.q_ref.tolist(), [0.0] * arm.model.nq)
        q, start = kind.target(arm, np.array(self._action[:n]), np.array(last))
        step = 1.0 / policy.rate
        v = end_velocity(q - start, np.array(change), step)
        # A closing gripper moves what it touches, and the arm where that does not give way.
        closing = gripper is not None and gripper.gripping and gripper.moving
        arm.servo(q, v, step, contact=closing)
        self._motion = q.tolist(), (q - start).tolist()

    def _observe(self, policy: OnnxPolicy) -> dict[str, np.ndarray]:
        """Return the observations of the cell, under the names that the policy has for them."""
        if self._observations is None:
            robots = {self._robot_name: self._robots[self._robot_name]}
            self._observations = Observations(self.cell, robots)
            policy.check({name: s.shape for name, s in self._named(self._observations.specs)})
        return dict(self._named(self._observations.read()))

    def _named(self, values: Mapping[str, T]) -> Iterator[tuple[str, T]]:
        """Yield observations; those of the port's object also under the name 'object'."""
        yield from values.items()
        prefix = f"{self.object}_"
        for name, value in values.items():
            if self.object and name.startswith(prefix):
                yield OBJECT + name.removeprefix(prefix), value

    def _grip(self, step: float) -> None:
        """Open or close the gripper; what it holds becomes the arm's payload.

        Numbers nearer to zero than 1 and -1 do so later in the step, as in episodes.
        """
        gripper = self._robots[self._robot_name].gripper
        if gripper is None:
            return
        number = self._action[-1]
        if self.cell.time >= self._time + (1.0 - min(abs(number), 1.0)) * step - 1e-9:
            command_gripper(gripper, number > 0.0)
        payload = held_payload(self.cell, gripper, self.T_wt, self.arm.payload)
        if payload is not self.arm.payload:
            self.arm.payload = payload


def _joint_target(arm: Arm, action: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return action, last


def _cartesian_delta(
    arm: Arm, action: np.ndarray, last: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    T_wt = displaced(arm.model.pose(arm.q), action)
    return differential_ik(arm.model, arm.q_ref, T_wt), arm.q_ref


class _Kind(NamedTuple):
    """A kind of actions, as in `bt_manip.episodes`.

    Attributes:
        size: Returns the number of values, without that of the gripper.
        target: Returns the target and where it is counted from [rad]; arguments are the arm, the
            values and the last target.
    """

    size: Callable[[Arm], int]
    target: Callable[[Arm, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


ACTIONS = {
    "joint_targets": _Kind(lambda arm: arm.model.nq, _joint_target),
    "cartesian_deltas": _Kind(lambda arm: 6, _cartesian_delta),
}
"""Kinds of actions that can be run in a tree."""
