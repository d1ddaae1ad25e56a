"""What a step of an environment costs, beside the physics alone over the same states.

``python -m benchmarks.bench_environments`` measures only training with Stable-Baselines3, by an
interpreter that has it: ``.venv-clients/bin/python`` after ``make test-clients``.
"""

import functools
import importlib.util
import resource
import statistics
import time
from pathlib import Path
from typing import Any

import gymnasium
import mujoco
import numpy as np

from bt_manip.cell import integration_state
from bt_manip.runner import Run, RunObserver
from bt_manip_learn.envs import LearningTask
from bt_manip_learn.envs.vector_env import BatchEnvironment

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


def _resident() -> int:
    """Return the memory of this process [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def batch(count: int, steps: int = 15) -> tuple[float, ...]:
    """Time a batch, its physics, and single environments with the same actions; medians [s].

    Returns:
        A step of one environment in the batch, by the wall; by processors, Python's part, and the
        physics; by the wall, the same physics alone, and a step of a single environment with
        native_pd, and with computed torque; and the memory of an environment in the batch [bytes].
    """
    options = {"reward": "dense", "disable_env_checker": True}
    memory = _resident()
    several = BatchEnvironment("pick_place", count, reward="dense")
    several.reset(seed=0)
    several.step(np.zeros(several.action_space.shape, np.float32))
    memory = _resident() - memory
    singles = [
        gymnasium.make("bt_manip/PickPlace-v0", controller=name, **options)
        for name in ("native_pd", "computed_torque")
    ]
    for single in singles:
        single.reset(seed=0)
    calls: list[Any] = []  # those of MuJoCo in a step

    def keeping(group: Any, rollout: Any) -> Any:
        def call(*args: Any, **options: Any) -> None:
            calls.append((group, group.state.copy(), functools.partial(rollout, *args, **options)))
            calls[-1][-1]()

        return call

    for group in several.simulations:
        group.rollout = keeping(group, group.rollout)
    rng, wall = np.random.default_rng(0), time.perf_counter
    whole, python, physics, alone, one = [], [], [], [], ([], [])
    for _ in range(steps):
        actions = 0.2 * rng.uniform(-1, 1, several.action_space.shape).astype(np.float32)
        start = wall(), _clock(), time.process_time()
        several.step(actions)
        whole.append((wall() - start[0]) / count)
        python.append((_clock() - start[1]) / count)  # MuJoCo has other threads
        physics.append((time.process_time() - start[2]) / count - python[-1])
        for group, state, _ in calls:
            group.state[:] = state
        begin = wall()
        for *_, call in calls:
            call()
        alone.append((wall() - begin) / count)
        calls.clear()
        for times, single in zip(one, singles, strict=True):
            for action in actions[:4]:
                begin = wall()
                single.step(action)
                times.append(wall() - begin)
    several.close()
    medians = [statistics.median(times) for times in (whole, python, physics, alone, *one)]
    return (*medians, memory / count)


def training(rounds: int = 3, steps: int = 4096) -> list[tuple[str, str, str]]:
    """Time PPO in a batch and in processes by the wall, in alternation; none without it.

    In each round the environments of the batch make an episode each, resets included.
    """
    if importlib.util.find_spec("stable_baselines3") is None:
        return []
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import SubprocVecEnv

    from bt_manip_learn.envs.stable_baselines import BatchVecEnv

    torch.set_num_threads(1)
    options: dict[str, Any] = {"reward": "dense", "max_episode_steps": steps // 64}
    single = functools.partial(
        gymnasium.make,
        "bt_manip_learn.envs:bt_manip/PickPlace-v0",
        controller="native_pd",
        **options,
    )
    models = [
        PPO(
            "MultiInputPolicy", env, n_steps=steps // env.num_envs, batch_size=512, n_epochs=5,
            device="cpu",
        )
        for env in (BatchVecEnv("pick_place", 64, **options), SubprocVecEnv([single, single]))
    ]  # fmt: skip
    times: list[list[float]] = [[], []]
    for number in range(rounds + 1):
        for model, found in zip(models, times, strict=True):
            start = time.perf_counter()
            model.learn(steps, reset_num_timesteps=False)
            if number:  # not the first start
                found.append(time.perf_counter() - start)
    for model in models:
        model.get_env().close()
    batched, apart = (steps / statistics.median(one) for one in times)
    return [
        (
            "training by PPO in a batch of 64, updates included, pick_place, dense reward",
            f"{batched:.0f} steps/s",
            f"{batched / apart:.1f} times SubprocVecEnv of two, {apart:.0f} steps/s",
        )
    ]


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
    whole, python, physics, alone, native, single, memory = batch(64)
    what = "step of 64 environments in a batch, joint_targets, dense reward, state observations"
    return [
        *found,
        (
            what,
            f"{1 / whole:.0f} steps/s: {1e6 * python:.0f} us of Python, {1e6 * physics:.0f} us of "
            "physics, at the same time",
            f"{alone / whole:.2f} of two bare cores (at least 0.75), "
            f"{single / whole:.1f} times one environment, {native / whole:.1f} with native_pd",
        ),
        ("memory of an environment in a batch", f"{memory / 1e6:.1f} MB", ""),
        *training(),
    ]


if __name__ == "__main__":
    for row in training():
        print(*row, sep=": ")
