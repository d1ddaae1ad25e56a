"""What a run of pick_place costs: a control step beside the physics alone, and the whole."""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest.mock import patch

import mujoco
import numpy as np

from bt_manip.behaviours import MotionBehaviour
from bt_manip.cell import Cell
from bt_manip.cell.physics.state import integration_state
from bt_manip.plugins import load_plugins
from bt_manip.record.report.recorder import Recorder
from bt_manip.runner import Run, RunObserver, prepare, request_of

CYCLES = 3
WHOLE_RUNS = {"pick_place": 5, "two_arms": 3, "sort_blocks": 1}  # cycles
LEAST_SHARE = {"pick_place": 0.42, "two_arms": 0.33, "sort_blocks": 0.68}
BLOCK = 10  # ticks
IMPORTS = "import mujoco, pinocchio; from dm_control import composer"
FIRST_STEP = """
import os, runpy, sys
from bt_manip.cell import Cell
Cell.step = lambda *_, **__: os._exit(0)
sys.argv = ["bt-manip", "run", "pick_place", "--quiet"]
runpy.run_module("bt_manip", run_name="__main__")
"""
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION


@dataclass
class Keeper(RunObserver):
    """Keeps the states between all control steps, and the model that each belongs to."""

    steps: list[tuple[mujoco.MjModel, np.ndarray]] = field(default_factory=list)

    def run_started(self, run: Any) -> None:
        """Look at the run's cell."""
        self._cell = run.station.cell

    def after_step(self) -> None:
        """Keep the state, which has the controls of the step before it."""
        self.steps.append((self._cell.model, integration_state(self._cell.model, self._cell.data)))


class Timer(RunObserver):
    """Times whole ticks, and between blocks of them the physics alone from the same states."""

    def __init__(self, kept: Keeper) -> None:
        """Replay what was kept of the same run."""
        self._kept, self._done = kept.steps, 0
        self._ticks = 0
        self._model: mujoco.MjModel | None = None
        self.whole: list[float] = []  # [s] a control step, its share of the tick included
        self.alone: list[float] = []  # [s] a step of the physics

    def run_started(self, run: Any) -> None:
        """Note how many steps a tick has."""
        self._steps = run.request.steps_per_tick
        self._began = time.perf_counter()

    def after_tick(self) -> None:
        """Take the time of the tick and its steps; now and then replay."""
        self.whole.append((time.perf_counter() - self._began) / self._steps)
        self._ticks += 1
        if self._ticks % BLOCK == 0:
            self.replay(BLOCK * self._steps)
        self._began = time.perf_counter()

    def replay(self, steps: int) -> None:
        """Time the physics alone from the next states."""
        clock = time.perf_counter
        for i in range(max(self._done, 1), self._done + steps):
            (model, before), (same, after) = self._kept[i - 1], self._kept[i]
            if model is not same:
                continue
            if model is not self._model:
                self._model, self._data = model, mujoco.MjData(model)
            mujoco.mj_setState(model, self._data, after, _STATE)
            controls = self._data.ctrl.copy()
            mujoco.mj_setState(model, self._data, before, _STATE)
            self._data.ctrl[:] = controls
            start = clock()
            mujoco.mj_step(model, self._data)
            self.alone.append(clock() - start)
        self._done += steps


def _prepare(cycles: int = CYCLES, tree: str = "pick_place", **settings: str) -> Run:
    parts = load_plugins().parts
    return prepare(request_of(tree, parts, cycles=cycles, settings=settings), parts)


class Judge(RunObserver):
    """Judges the contacts of every step, and does nothing else of what a recorder does."""

    def run_started(self, run: Any) -> None:
        """Look at the run's cell."""
        self._cell = run.station.cell

    def after_step(self) -> None:
        """Judge."""
        self._cell.contact_monitor.summary()


def control_step(observer: RunObserver) -> tuple[float, float]:
    """Time a control step with all that runs in it, and the physics alone; medians [s]."""
    keeper = Keeper()
    _prepare().execute([keeper])
    timer = Timer(keeper)
    _prepare().execute([observer, timer])
    return statistics.median(timer.whole), statistics.median(timer.alone)


def whole_run(tree: str = "pick_place", cycles: int = 5) -> tuple[float, float, float]:
    """Give the real-time factors of a run, start-up apart, and of its bare steps; its mean cycle.

    The bare factor is that of `mujoco.mj_step` alone from the states of the same run, as a mean.
    """
    recorder = Recorder(tree, 0)
    _prepare(cycles, tree).execute([recorder])
    report = recorder.report()
    keeper = Keeper()
    run = _prepare(cycles, tree)
    run.execute([keeper])
    timer = Timer(keeper)
    timer.replay(len(keeper.steps))
    bare = run.station.cell.dt / statistics.mean(timer.alone)
    return report.real_time_factor, bare, report.simulated_s / cycles


def planning_and_spawning(cycles: int = 8) -> tuple[float, float, float]:
    """Time what a cycle plans, its spawn and remove, and the physics alone; medians [s].

    The first cycle is left out.
    """
    times: dict[str, list[float]] = defaultdict(list)

    def timed(name: str, method: Callable[..., Any]) -> Callable[..., Any]:
        def call(self: Any, *args: Any, **kwargs: Any) -> Any:
            start = time.perf_counter()
            try:
                return method(self, *args, **kwargs)
            finally:
                times[name or type(self).__name__].append(time.perf_counter() - start)

        return call

    keeper = Keeper()
    with (
        patch.object(MotionBehaviour, "initialise", timed("", MotionBehaviour.initialise)),
        patch.object(Cell, "add", timed("add", Cell.add)),
        patch.object(Cell, "remove", timed("remove", Cell.remove)),
    ):
        run = _prepare(cycles)
        times.clear()  # the scene's own
        run.execute([keeper])
    timer = Timer(keeper)
    timer.replay(len(keeper.steps))
    each = {name: statistics.median(found[1:]) for name, found in times.items()}
    spawning = each.pop("add") + each.pop("remove")
    return sum(each.values()), spawning, statistics.median(timer.alone)


def blended_cycle(cycles: int = 20) -> float:
    """Give the mean cycle with blended motions [s]."""
    run = _prepare(cycles, blend_radius="0.35")
    run.execute([])
    return run.station.cell.time / cycles


def command(*arguments: str, runs: int = 5, **variables: str) -> float:
    """Time a whole process; median [s]."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "bt_manip", *arguments],
            check=True, capture_output=True, env={**os.environ, **variables},
        )  # fmt: skip
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def start(pairs: int = 7) -> tuple[float, float]:
    """Time processes, in alternation: a run up to its first step, and bare imports; medians [s]."""
    times: dict[str, list[float]] = {FIRST_STEP: [], IMPORTS: []}
    headless = {**os.environ, "MUJOCO_GL": "disable"}
    for _ in range(pairs):
        for code, found in times.items():
            began = time.perf_counter()
            subprocess.run(
                [sys.executable, "-c", code], check=True, capture_output=True, env=headless
            )
            found.append(time.perf_counter() - began)
    first, imports = map(statistics.median, times.values())
    return first, imports


def help_with_plugins(count: int = 20) -> float:
    """Time the help where many plugins are installed, all of which import mujoco; median [s]."""
    with tempfile.TemporaryDirectory() as temporary:
        for i in range(count):
            name = f"bt_manip_many{i}"
            Path(temporary, f"{name}_main.py").write_text("import mujoco\n")
            Path(temporary, f"{name}.py").write_text(
                "from bt_manip import hookimpl\n\n\n@hookimpl\ndef register_commands(register):\n"
                f"    register('many{i}', '{name}_main:main')\n"
            )
            info = Path(temporary, f"{name}-1.0.dist-info")
            info.mkdir()
            (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
            (info / "entry_points.txt").write_text(f"[bt_manip]\nmany{i} = {name}\n")
        return command("--help", PYTHONPATH=temporary)


def rows() -> list[tuple[str, str, str]]:
    """Give the figures: what, how much, beside what."""
    whole, alone = control_step(Judge())
    recorded, beside = control_step(Recorder("pick_place", 0))
    runs = {tree: whole_run(tree, cycles) for tree, cycles in WHOLE_RUNS.items()}
    planning, spawning, step = planning_and_spawning()
    first, imports = start()
    return [
        (
            "control step: control, trajectory, contacts, its share of the tick",
            f"{1e6 * whole:.1f} us",
            f"{whole / alone:.2f} x mj_step, {1e6 * alone:.1f} us",
        ),
        (
            "the same, with all that the report needs",
            f"{1e6 * recorded:.1f} us",
            f"{recorded / beside:.2f} x mj_step, {1e6 * beside:.1f} us (at most 1.75)",
        ),
        *(
            (
                f"real-time factor of {tree}, all included",
                f"{factor:.1f}",
                f"{factor / bare:.2f} of bare mj_step, {bare:.0f} (at least {LEAST_SHARE[tree]})",
            )
            for tree, (factor, bare, _) in runs.items()
        ),
        (
            "planning in a cycle",
            f"{1e3 * planning:.1f} ms",
            f"{planning / step:.0f} x mj_step (at most 2000)",
        ),
        (
            "spawn and remove of a cycle",
            f"{1e3 * spawning:.1f} ms",
            f"{spawning / step:.0f} x mj_step (at most 350)",
        ),
        ("mean cycle of pick_place", f"{runs['pick_place'][2]:.2f} s simulated", "at most 5 s"),
        ("the same, blended", f"{blended_cycle():.2f} s simulated", "at most 3.3 s"),
        (
            "from the command bt-manip run pick_place to the first physics step",
            f"{first:.2f} s",
            f"{first / imports:.2f} x importing mujoco, pinocchio and composer, {imports:.2f} s "
            "(at most 2.3)",
        ),
        ("bt-manip --help", f"{command('--help'):.2f} s", ""),
        ("the same, with 20 plugins", f"{help_with_plugins():.2f} s", "at most 0.3 s"),
        ("bt-manip list", f"{command('list'):.2f} s", ""),
        ("bt-manip run pick_place, a cycle", f"{command('run', 'pick_place'):.2f} s", ""),
    ]
