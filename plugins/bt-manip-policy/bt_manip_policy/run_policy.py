"""Run a learned policy."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from bt_manip.agents import (
    Observations,
    command_gripper,
    differential_ik,
    displaced,
    end_velocity,
    held_payload,
)
from bt_manip.arm import Arm
from bt_manip.behaviours import ArmBehaviour
from bt_manip.bt import Input, Status
from bt_manip.exceptions import PortError, did_you_mean, shown

from .policy_process import LoadedPolicy, shared_process

T = TypeVar("T")

ONNX = "bt_manip_policy.onnx_policy:OnnxPolicy"
"""Makes policies; only their process imports onnxruntime."""

OF_OBJECTS = {
    "position": (3,), "rotation": (6,), "velocity": (6,), "contact_wrench": (6,),
    "joint_positions": (),
}  # fmt: skip
"""Observations of objects, with their shapes; that of joints depends on the object."""

OBJECT = "object_"
"""Beginning of the names of observations of the object that the port ``object`` names."""


class RunPolicy(ArmBehaviour):
    """Let a learned policy act until something else halts it, or fail after a time.

    Each action goes to the arm as `Arm.servo`: it keeps all limits, and the arm stops by itself on
    an external force. A halted policy leaves the arm at rest. Actions of environments move along
    cubics instead (`bt_manip.agents`), which repeat recorded targets but keep fewer limits.
    """

    model = Input(str, doc="ONNX file of the policy.")
    object = Input(str, default="", doc="Name of the object that the policy observes as 'object'.")
    time_limit = Input(float, default=10.0, doc="Simulated time after which it fails [s].")

    reports_time = True

    amounts: ClassVar = {"time_limit": "s"}
    memory = (*ArmBehaviour.memory, "_time", "_motion", "_action", "_next")

    _policy: LoadedPolicy | None = None
    _observations: Observations | None = None
    _time = 0.0  # [s] simulated, of the present action
    _motion: Sequence[Sequence[float]] | None = None  # [rad] last target, and its change to there
    _action: Sequence[float] = ()  # the present one
    _next: Sequence[Sequence[float]] = ()  # those that follow it without a new observation

    def setup(self, **infrastructure: Any) -> None:
        """Load the policy and check that it fits, as far as ports and objects are known already.

        Raises:
            PolicyError: If it cannot be loaded, does not fit, or does not act.
        """
        super().setup(**infrastructure)
        with suppress(PortError):  # an entry is written later
            policy = self._load()
            self._check(policy)

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

    def _load(self) -> LoadedPolicy:
        """Return the policy that the port names.

        Raises:
            PolicyError: If it is no policy.
        """
        path = str(self.model)
        if self._policy is None or self._policy.name != path:
            self._policy = LoadedPolicy(shared_process(), path, ONNX, path)
        return self._policy

    def _check(self, policy: LoadedPolicy) -> None:
        """Let the policy act once; observations of objects that are not there yet are zero.

        Raises:
            PolicyError: If it does not fit the station, or does not act.
        """
        size = self._action_size(policy)
        observed = dict(self._named(self._present().read()))
        for name, expected in policy.inputs.items():
            shape = None if name in observed else self._shape_of_absent(name)
            if shape is not None:
                observed[name] = np.zeros(shape or [n or 1 for n in expected], np.float32)
        policy.check({name: value.shape for name, value in observed.items()})
        policy.act(observed, size, trial=True)

    def _act(self) -> None:
        """Command the next action.

        Raises:
            PolicyError: If the policy does not fit the station, or returns no valid action.
            MotionError: If the arm cannot move now.
        """
        policy, arm = self._load(), self.arm
        size = self._action_size(policy)
        kind = ACTIONS[policy.action]
        n = kind.size(arm)
        gripper = self._robots[self._robot_name].gripper
        if not self._next:
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

    def _action_size(self, policy: LoadedPolicy) -> int:
        """Return the number of values of an action of this robot.

        Raises:
            PolicyError: If the policy has actions of an unknown kind.
        """
        if policy.action not in ACTIONS:
            known = did_you_mean(policy.action, ACTIONS)
            raise policy.error(f"has actions {shown(policy.action)}{known}")
        gripper = self._robots[self._robot_name].gripper
        return ACTIONS[policy.action].size(self.arm) + (gripper is not None)

    def _present(self) -> Observations:
        robots = {self._robot_name: self._robots[self._robot_name]}
        return Observations(self.cell, robots)

    def _observe(self, policy: LoadedPolicy) -> dict[str, np.ndarray]:
        """Return the observations of the cell, under the names that the policy has for them."""
        if self._observations is None:
            self._observations = self._present()
            policy.check({name: s.shape for name, s in self._named(self._observations.specs)})
        return dict(self._named(self._observations.read()))

    def _shape_of_absent(self, name: str) -> tuple[int, ...] | None:
        """Return the shape of an observation of an object that may still come.

        Returns:
            Empty where the shape depends on the object; None where the name is no such observation.
        """
        known = {*self.cell.entities, "robot"}
        if self._object_name == "":
            known.add("object")
        for quantity, shape in OF_OBJECTS.items():
            owner = name.removesuffix(f"_{quantity}")
            if owner != name and owner not in known and not owner.startswith("robot_"):
                return shape
        return None

    @property
    def _object_name(self) -> str | None:
        """Name of the object of the port; None where its entry is written later."""
        try:
            return str(self.object)
        except PortError:
            return None

    def _named(self, values: Mapping[str, T]) -> Iterator[tuple[str, T]]:
        """Yield observations; those of the port's object also under the name 'object'."""
        yield from values.items()
        if object_name := self._object_name:
            prefix = f"{object_name}_"
            for name, value in values.items():
                if name.startswith(prefix):
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
    """A kind of actions, as in `bt_manip.agents`.

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
