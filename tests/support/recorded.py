"""A short recording, and what was seen in its run."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bt_manip.behaviours import MoveToConfiguration, RemoveObject, SpawnObject
from bt_manip.bt import Node, Sequence, Sleep
from bt_manip.runner import Run, RunObserver
from bt_manip_recording import McapRecorder, Recording


def coming_and_going() -> Node:
    return Sequence(
        "root",
        SpawnObject("come", object="{cube}"),
        MoveToConfiguration("turn", configuration=[1.0, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]),
        Sleep("rest", msec=50),
        RemoveObject("go", object="{cube}"),
        Sleep("end", msec=50),
    )


class Cube(RunObserver):
    """Keeps time, running nodes and the position of the cube after each step and tick."""

    def run_started(self, run: Run) -> None:
        self.cell, self.tree = run.station.cell, run.tree
        self.steps: list[tuple[float, str]] = []
        self.ticks: list[tuple[float, Any]] = []

    def after_step(self) -> None:
        running = [n.name for n in self.tree.nodes[1:] if n.engine_status.name == "RUNNING"]
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
