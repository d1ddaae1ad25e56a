"""Run a learned policy."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from bt_manip.behaviours import ArmBehaviour
from bt_manip.bt import Input, Status
from bt_manip.exceptions import PortError, did_you_mean, shown
from bt_manip.registry import Registry
from bt_manip_learn.agents import (
    command_gripper,
    differential_ik,
    displaced,
    end_velocity,
    held_payload,
)

from .policy_inputs import PolicyInputs, with_history
from .policy_kind import PolicyKind
from .policy_process import LoadedPolicy, shared_process

Chunk = tuple[int, Sequence[Sequence[float]]]
"""A prediction of actions: the steps since, and the actions."""

ACTIONS = ("joint_targets", "cartesian_deltas")
"""Kinds of actions, as in `bt_manip_learn.agents`, that can be run in a tree."""


class RunPolicy(ArmBehaviour):
    """Execute a learned policy until halted; fail after a time limit.

    Each action is executed by `Arm.servo`, within all limits, and the arm stops by itself on an
    external force. A halted policy leaves the arm at rest. In contrast, actions of environments
    move along cubics (`bt_manip_learn.agents`), which reproduce recorded targets but respect fewer
    limits.
    """

    model = Input(str, doc="File of the policy.")
    object = Input(str, default="", doc="Name of the object that the policy observes as 'object'.")
    time_limit = Input(
        float, default=10.0, doc="Simulated time after which it fails [s].", at_least=0.0
    )
    policy_kind = Input(str, default="onnx", doc="Registered kind of the policy.")

    reports_time = True

    memory = (
        *ArmBehaviour.memory, "_time", "_motion", "_action", "_next", "_chunks",
    )  # fmt: skip

    _policy: LoadedPolicy | None = None
    _inputs: PolicyInputs | None = None
    _time = 0.0  # [s] simulated time of the present action
    _motion: Sequence[Sequence[float]] | None = None  # [rad] last target, and its last change
    _action: Sequence[float] = ()  # present action
    _next: Sequence[Sequence[float]] = ()  # following actions without a new observation
    _chunks: Sequence[Chunk] = ()  # predictions to ensemble, oldest first
    _past: Sequence[dict[str, np.ndarray]] = ()  # observations, the present ones last
    _states: Mapping[str, np.ndarray] = {}  # recurrent states; none at the start

    def setup(self, **infrastructure: Any) -> None:
        """Load the policy and check that it fits, as far as ports and objects are known.

        Raises:
            PolicyError: If it cannot be loaded, does not fit, or does not act.
        """
        super().setup(**infrastructure)
        self._kinds: Registry[PolicyKind] = infrastructure["policies"]
        with suppress(PortError):  # an entry is written later
            policy = self._load()
            self._check(policy)

    def start(self) -> None:
        """Execute the first action."""
        self._close_inputs()
        self._motion, self._next, self._time = None, (), self.cell.time
        self._chunks, self._past, self._states = (), (), {}
        self._act()

    def update(self) -> Status:
        """Execute actions at their rate, up to the time limit."""
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
        self._close_inputs()

    def get_state(self) -> dict[str, Any]:
        """Return its state as plain data, including observations and recurrent states."""
        past = [_plain(one) for one in self._past]
        return {**super().get_state(), "past": past, "states": _plain(self._states)}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state of `get_state`."""
        super().set_state(state)
        self._close_inputs()
        self._past = [_arrays(one) for one in state["past"]]
        self._states = _arrays(state["states"])

    def _close_inputs(self) -> None:
        if self._inputs is not None:
            self._inputs.close()
            self._inputs = None

    def _load(self) -> LoadedPolicy:
        """Return the policy of the port."""
        path, kind = str(self.model), self._kinds.get(self.policy_kind)
        if self._policy is None or self._policy.path != path:
            self._policy = LoadedPolicy(shared_process(kind.memory), kind, path)
        return self._policy

    def _check(self, policy: LoadedPolicy) -> None:
        """Execute the policy once, with zeros for objects that are absent yet."""
        size = self._action_size(policy)
        inputs = self._make_inputs(policy)
        try:
            observed = inputs.read_or_zero()
        finally:
            inputs.close()
        policy.check(inputs.known() | {name: value.shape for name, value in observed.items()})
        policy.act(with_history([observed], policy.history), size, trial=True)

    def _act(self) -> None:
        """Command the next action."""
        policy, arm = self._load(), self.arm
        size = self._action_size(policy)
        gripper = self._robots[self._robot_name].gripper
        self._action, self._next = self._choose(policy, size)
        numbers = np.array(self._action[: size - (gripper is not None)])
        last, change = self._motion or (arm.q_ref.tolist(), [0.0] * arm.model.nq)
        if policy.action == "joint_targets":
            q, start = numbers, np.array(last)
        else:
            T_wt = displaced(arm.model.pose(arm.q), numbers)
            q, start = differential_ik(arm.model, arm.q_ref, T_wt), arm.q_ref
        step = 1.0 / policy.rate
        v = end_velocity(q - start, np.array(change), step)
        # A closing gripper moves touched objects, or the arm if they do not yield.
        closing = gripper is not None and gripper.gripping and gripper.moving
        arm.servo(q, v, step, contact=closing)
        self._motion = q.tolist(), (q - start).tolist()

    def _choose(
        self, policy: LoadedPolicy, size: int
    ) -> tuple[Sequence[float], Sequence[Sequence[float]]]:
        """Return the present action, and the actions that follow without a new observation."""
        if policy.history > 1 or not self._next:
            self._past = [*self._past, self._observe(policy)][-policy.history :]
        if self._next:
            return self._next[0], self._next[1:]
        observed = with_history(list(self._past), policy.history)
        actions, self._states = policy.act(observed, size, self._states)
        rows = actions.tolist()
        if policy.ensemble is not None:
            older = [(age + 1, r) for age, r in self._chunks if age + 1 < len(r)]
            self._chunks = [*older, (0, rows)]
            return ensembled(self._chunks, policy.ensemble), ()
        return rows[0], rows[1 : policy.execute or None]

    def _action_size(self, policy: LoadedPolicy) -> int:
        if policy.action not in ACTIONS:
            known = did_you_mean(policy.action, ACTIONS)
            raise policy.error(f"has actions {shown(policy.action)}{known}")
        gripper = self._robots[self._robot_name].gripper
        size = self.arm.model.nq if policy.action == "joint_targets" else 6
        return size + (gripper is not None)

    def _make_inputs(self, policy: LoadedPolicy) -> PolicyInputs:
        name, object_name = self._robot_name, None
        with suppress(PortError):  # its entry is written later
            object_name = str(self.object)
        return PolicyInputs(policy, self.cell, {name: self._robots[name]}, object_name)

    def _observe(self, policy: LoadedPolicy) -> dict[str, np.ndarray]:
        """Return the present observations, by their names in the policy."""
        if self._inputs is None:
            self._inputs = self._make_inputs(policy)
            policy.check(self._inputs.known())
        return self._inputs.read()

    def _grip(self, step: float) -> None:
        """Open or close the gripper; a held object becomes the arm's payload.

        Values with a magnitude below 1 act later in the step, as in episodes.
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


def ensembled(chunks: Sequence[Chunk], decay: float) -> list[float]:
    """Return the weighted mean of several predictions for the present step.

    The i-th oldest prediction weighs ``exp(-decay i)`` (Zhao, Kumar, Levine and Finn 2023, Learning
    Fine-Grained Bimanual Manipulation with Low-Cost Hardware, section IV-B).
    """  # (n,)
    weights = np.exp(-decay * np.arange(len(chunks)))
    present = np.array([rows[age] for age, rows in chunks])
    return ((weights / weights.sum()) @ present).tolist()


def _plain(arrays: Mapping[str, np.ndarray]) -> dict[str, Any]:
    return {name: [one.dtype.str, one.tolist()] for name, one in arrays.items()}


def _arrays(plain: Mapping[str, Any]) -> dict[str, np.ndarray]:
    return {name: np.array(values, dtype) for name, (dtype, values) in plain.items()}
