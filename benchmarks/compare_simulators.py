"""Measure bt-manip, robosuite and ManiSkill: each in a process of its own, on one core.

``python benchmarks/compare_simulators.py --python robosuite=PYTHON --python maniskill=PYTHON``
prints a table. PYTHON is the interpreter of an environment in which the package is installed; one
that is not named is measured with this interpreter, or left out where it is not installed.

Every framework makes the same number of steps of 50 ms with a Panda and state observations; actions
are displacements of the joints from a seeded generator. Times are CPU times of the process, so that
other work on the machine counts little. The frameworks run in turn, and medians are shown.
"""

import argparse
import importlib.metadata
import importlib.util
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

Physics = Callable[[Any, float, np.ndarray], float]

STEP_TIME = 0.05  # [s] 20 Hz, the default of all three
PACKAGES = {
    "bt-manip": ("bt_manip", "mujoco"),
    "robosuite": ("robosuite", "mujoco"),
    "maniskill": ("mani_skill", "sapien"),
}
ROWS = {
    "versions": "{}",
    "environment": "{}",
    "physics_step": "{:.0f} ms",
    "startup": "{:.1f} s",
    "reset": "{:.1f} ms",
    "steps": "{:.0f} /s",
    "real_time_factor": "{:.1f}",
    "physics": "{:.1f} ms",
    "physics_share": "{:.2f}",
    "image": "{}",
    "expert": "{}",
}
_clock = time.process_time


def bt_manip(images: bool) -> tuple[Any, Physics, str, float]:
    """Make bt-manip's environment; return what times its physics, its name and time step, too."""
    import gymnasium

    import bt_manip_learn.envs  # noqa: F401  registers the ids

    options = (
        {"kinds": ("rgb",), "cameras": ("overview",), "width": 128, "height": 128}
        if images
        else None
    )
    env: Any = gymnasium.make("bt_manip/PickPlace-v0", robot="panda", images=options).unwrapped
    env.reset(seed=0)
    space = env.action_space
    cell = env.task.episodes.station.cell

    def action(draw: np.ndarray) -> np.ndarray:
        """Displace the measured joints by at most 0.05 rad."""
        joints = env.task.episodes.station.robot.q + 0.05 * draw[:7]
        return np.clip([*joints, draw[7]], space.low, space.high)

    env.draw = action
    env.mujoco = lambda: (cell.model, cell.data)
    return env, mujoco_physics, "bt_manip/PickPlace-v0", cell.model.opt.timestep


def robosuite(images: bool) -> tuple[Any, Physics, str, float]:
    """Make robosuite's environment; see `bt_manip`."""
    import robosuite as suite
    from robosuite.controllers import load_composite_controller_config

    config = load_composite_controller_config(controller="BASIC", robot="Panda")
    arm = config["body_parts"]["right"]
    arm.update(type="JOINT_POSITION", input_max=1, input_min=-1, output_max=0.05, output_min=-0.05)
    arm.update(kp=50, damping_ratio=1, impedance_mode="fixed", interpolation=None)
    env = suite.make(
        "Lift",
        robots="Panda",
        controller_configs=config,
        has_renderer=False,
        has_offscreen_renderer=images,
        use_camera_obs=images,
        camera_names="agentview",
        camera_heights=128,
        camera_widths=128,
        control_freq=round(1 / STEP_TIME),
        ignore_done=True,
        seed=0,
    )
    env.draw = lambda draw: draw
    env.mujoco = lambda: (env.sim.model._model, env.sim.data._data)
    return env, mujoco_physics, "Lift", env.model_timestep


def maniskill(images: bool, control: str = "pd_joint_delta_pos") -> tuple[Any, Physics, str, float]:
    """Make ManiSkill's environment; without a Vulkan device it has no visual shapes."""
    import gymnasium
    import mani_skill.envs  # noqa: F401  registers the ids
    import sapien
    import torch

    torch.set_num_threads(1)
    options: dict[str, Any] = {
        "obs_mode": "state",
        "sim_backend": "physx_cpu",
        "render_backend": "none",
    }
    if images:
        options.update(obs_mode="rgb", render_backend="cpu")
    elif not sapien.Device("cpu").can_render():
        from unittest import mock

        from sapien.wrapper.actor_builder import ActorBuilder

        sapien.render.RenderMaterial = mock.MagicMock
        for name in dir(ActorBuilder):
            if name.startswith("add_") and name.endswith("visual"):
                setattr(ActorBuilder, name, lambda self, *_, **__: self)
    made: Any = gymnasium.make("PickCube-v1", control_mode=control, **options)
    env = made.unwrapped
    env.draw = lambda draw: draw.astype(np.float32)
    return env, physx_physics, "PickCube-v1", 1 / env.sim_freq


def mujoco_physics(env: Any, physics_step: float, draws: np.ndarray) -> float:
    """Return the time of the physics steps of an environment step, replayed by bare `mj_step`."""
    import mujoco

    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    times = []
    model, data = env.mujoco()
    bare, state = mujoco.MjData(model), np.empty(mujoco.mj_stateSize(model, kind))
    for draw in draws:
        mujoco.mj_getState(model, data, state, kind)
        env.step(env.draw(draw))
        mujoco.mj_setState(model, bare, state, kind)
        bare.ctrl[:] = data.ctrl
        start = _clock()
        for _ in range(round(STEP_TIME / physics_step)):
            mujoco.mj_step(model, bare)
        times.append(_clock() - start)
    return statistics.median(times)


def physx_physics(env: Any, physics_step: float, draws: np.ndarray) -> float:
    """Return the time that an environment step spends in the physics."""
    times, whole = [], env.scene.step

    def step() -> None:
        start = _clock()
        whole()
        times.append(_clock() - start)

    env.scene.step = step
    for draw in draws:
        env.step(env.draw(draw))
    env.scene.step = whole
    return statistics.median(times) * round(STEP_TIME / physics_step)


def timed(env: Any, draws: np.ndarray) -> float:
    """Return the mean time of a step [s]."""
    start = _clock()
    for draw in draws:
        env.step(env.draw(draw))
    return (_clock() - start) / len(draws)


def expert(name: str, episodes: int) -> str:
    """Return how often the scripted expert succeeds, and how fast it is."""
    if name == "robosuite":
        return "none"
    run = expert_bt_manip if name == "bt-manip" else expert_maniskill
    found = list(run(episodes))
    if not found:
        return "not measured"
    steps, successes, times = (sum(column) for column in zip(*found, strict=True))
    return f"{successes} of {episodes}, real-time factor {steps * STEP_TIME / times:.1f}"


def expert_bt_manip(episodes: int) -> Iterator[tuple[int, bool, float]]:
    """Yield steps, success and time [s] of the tree; from a cube on the table to the basket."""
    from bt_manip_learn.envs import LearningTask

    task = LearningTask("pick_place")
    for seed in range(episodes):
        start, steps = _clock(), 0
        task.reset(seed)
        while not task.episodes.success and steps < 400:
            task.episodes.expert_step()
            steps += 1
        yield steps, task.episodes.success, _clock() - start


def expert_maniskill(episodes: int) -> Iterator[tuple[int, bool, float]]:
    """Yield the same of the example with motion planning, which needs numpy below 2."""
    if int(np.__version__.split(".")[0]) >= 2:
        return  # mplib 0.1.1 ends the process
    from mani_skill.examples.motionplanning.panda.solutions import solvePickCube

    env = maniskill(False, "pd_joint_pos")[0]
    for seed in range(episodes):
        start = _clock()
        result = solvePickCube(env, seed=seed)
        planned = result != -1
        steps = int(result[-1]["elapsed_steps"]) if planned else 0
        yield steps, planned and bool(result[-1]["success"]), _clock() - start


def measure(name: str, steps: int, episodes: int) -> dict[str, Any]:
    """Measure a framework in this process."""
    make: Callable[[bool], Any] = {
        "bt-manip": bt_manip,
        "robosuite": robosuite,
        "maniskill": maniskill,
    }[name]
    env, physics, environment, physics_step = make(False)
    env.reset()
    startup = _clock()
    rng = np.random.default_rng(0)
    draws = rng.uniform(-1, 1, (steps, 8))
    timed(env, draws[: min(20, steps)])  # compiles and fills caches
    start = _clock()
    env.reset()
    reset = _clock() - start
    whole = timed(env, draws)
    env.reset()
    alone = physics(env, physics_step, draws)
    try:
        with_images = make(True)[0]
        with_images.reset()
        timed(with_images, draws[:5])
        image = f"{1e3 * (timed(with_images, draws[:20]) - whole):.0f} ms"
    except RuntimeError as error:
        image = f"none: {str(error).splitlines()[0]}"
    versions = [f"{part} {importlib.metadata.version(part)}" for part in PACKAGES[name]]
    return {
        "versions": ", ".join(versions),
        "environment": environment,
        "physics_step": 1e3 * physics_step,
        "startup": startup,
        "reset": 1e3 * reset,
        "steps": 1 / whole,
        "real_time_factor": STEP_TIME / whole,
        "physics": 1e3 * alone,
        "physics_share": alone / whole,
        "image": image,
        "expert": expert(name, episodes),
    }


def rounds(
    pythons: dict[str, str], repeats: int, arguments: list[str]
) -> Iterator[tuple[str, Any]]:
    """Measure all frameworks in turn; yield names and results."""
    environment = os.environ | {"OMP_NUM_THREADS": "1", "MUJOCO_GL": "egl"}
    for _ in range(repeats):
        for name, python in pythons.items():
            command = [python, __file__, "--measure", name, *arguments]
            ran = subprocess.run(command, env=environment, capture_output=True, text=True)
            if ran.returncode:
                print(f"{name}: {ran.stderr.strip().splitlines()[-1:]}", file=sys.stderr)
            else:
                yield name, json.loads(ran.stdout.splitlines()[-1])


def main() -> None:
    """Print the table, or with ``--measure`` the results of one framework as JSON."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--python", action="append", default=[], metavar="NAME=PYTHON")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--episodes", type=int, default=10, help="of the expert")
    parser.add_argument("--measure", choices=PACKAGES, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.measure:
        if hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
        print(json.dumps(measure(given.measure, given.steps, given.episodes)))
        return
    pythons = {
        name: sys.executable
        for name, (module, _) in PACKAGES.items()
        if importlib.util.find_spec(module)
    } | dict(one.split("=", 1) for one in given.python)
    arguments = ["--steps", str(given.steps), "--episodes", str(given.episodes)]
    results: dict[str, list[Any]] = {}
    for name, result in rounds(pythons, given.repeats, arguments):
        results.setdefault(name, []).append(result)
    print("| |", " | ".join(results), "|")
    print("|---" * (len(results) + 1) + "|")
    for row, form in ROWS.items():
        cells = []
        for found in results.values():
            values = [one[row] for one in found]
            number = isinstance(values[0], float)
            cells.append(form.format(statistics.median(values) if number else values[-1]))
        print(f"| {row.replace('_', ' ')} |", " | ".join(cells), "|")


if __name__ == "__main__":
    main()
