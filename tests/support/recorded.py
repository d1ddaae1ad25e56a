"""A short recording, and what was seen in its run."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bt_manip.behaviours import MoveToConfiguration, RemoveObject, SpawnObject
from bt_manip.bt import AlwaysFailure, Fallback, Node, Script, Sequence, Sleep
from bt_manip.runner import Run, RunObserver
from bt_manip_recording import McapRecorder, Recording


def coming_and_going(rest: int = 50) -> Node:
    """Return a task in which an object comes, stays while the arm rests [ms], and goes."""
    return Sequence(
        "root",
        Script(code="speed := 0.5"),
        SpawnObject("come", object="{cube}"),
        MoveToConfiguration("turn", configuration=[1.0, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]),
        Sleep("rest", msec=rest),
        RemoveObject("go", object="{cube}"),
        Fallback("rescue", AlwaysFailure("never"), Sleep("end", msec=50)),
    )


class Cube(RunObserver):
    """Keeps time, running nodes and the position of the cube after each step and tick."""

    def run_started(self, run: Run) -> None:
        self.cell, self.tree = run.station.cell, run.tree
        self.steps: list[tuple[float, str]] = []
        self.ticks: list[tuple[float, Any]] = []

    def after_step(self) -> None:
        leaves = [node for node in self.tree.nodes if not node.children]
        running = [node.name for node in leaves if node.engine_status.name == "RUNNING"]
        self.steps.append((self.cell.time, "; ".join(running)))

    def after_tick(self) -> None:
        present = "cube" in self.cell.entities
        position = self.cell.data.body("cube/cube").xpos.copy() if present else None
        self.ticks.append((self.cell.time, position))


@pytest.fixture(scope="module")
def recorded(
    make_run: Callable[..., Run], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Recording, Path, Cube]:
    """Record a run once; give the recording, its folder and what was seen."""
    folder = tmp_path_factory.mktemp("recorded")
    cube = Cube()
    make_run(coming_and_going()).execute([cube, McapRecorder(folder / "run.mcap")])
    return Recording(folder / "run.mcap"), folder, cube
