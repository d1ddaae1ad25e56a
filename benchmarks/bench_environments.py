"""What a step of an environment costs, beside the physics alone over the same states."""

import statistics
import time

import mujoco
import numpy as np

from bt_manip.cell import integration_state
from bt_manip.envs import LearningTask
from bt_manip.runner import Run, RunObserver

SEEDS = range(4)
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
# Times are those of the thread, not of the wall: other work on the machine does not count.
_clock = time.thread_time


def _expert(task: LearningTask, seed: int) -> list[np.ndarray]:
    """Return the actions of the expert in an episode."""
    task.reset(seed)
    actions = []
    while not task.episodes.success:
        task.action.watch()
        task.episodes.expert_step()
        actions.append(task.action.recorded())
    return actions


class _Controls(RunObserver):
    """Keeps the controls of all steps."""

    def run_started(self, run: Run) -> None:
        self._cell, self.kept = run.station.cell, []

    def after_step(self) -> None:
        self.kept.append(self._cell.data.ctrl.copy())


def step_and_physics(action: str, reward: str) -> tuple[float, float, float]:
    """Time resets, steps with observations, and the physics of these steps alone; medians [s]."""
    task = LearningTask("pick_place", action=action, reward=reward)
    log = _Controls()
    observed = LearningTask("pick_place", action=action, reward=reward, observers=(log,))
    cell = observed.episodes.station.cell
    resets, whole, alone = [], [], []
    for seed in SEEDS:
        actions = _expert(task, seed)
        observed.reset(seed)
        model, data = cell.model, cell.data
        starts: list[np.ndarray] = []
        controls: list[list[np.ndarray]] = []
        for one in actions:
            starts.append(integration_state(model, data))
            log.kept = []
            observed.action.step(one)
            controls.append(log.kept)
        start = _clock()
        task.reset(seed)
        resets.append(_clock() - start)
        bare = mujoco.MjData(model)
        for one, before, ctrl in zip(actions, starts, controls, strict=True):
            start = _clock()
            task.step(one)
            task.observe()
            whole.append(_clock() - start)
            mujoco.mj_setState(model, bare, before, _STATE)
            start = _clock()
            for values in ctrl:
                bare.ctrl[:] = values
                mujoco.mj_step(model, bare)
            alone.append(_clock() - start)
    return statistics.median(resets), statistics.median(whole), statistics.median(alone)


def rows() -> list[tuple[str, str, str]]:
    """Give the figures: what, how much, beside what."""
    found = []
    for action, reward in (
        ("joint_torques", "sparse"),
        ("joint_targets", "sparse"),
        ("joint_targets", "dense"),
        ("cartesian_deltas", "sparse"),
    ):
        reset, whole, alone = step_and_physics(action, reward)
        found.append(
            (
                f"step of pick_place, {action}, {reward} reward, state observations",
                f"{1e3 * whole:.2f} ms, reset {1e3 * reset:.0f} ms",
                f"{alone / whole:.2f} of bare mj_step's real-time factor (at least 0.35)",
            )
        )
    return found
