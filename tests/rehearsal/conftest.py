"""Simulated robots in processes of their own, and the scenes that they and bt-manip are given."""

import os
import sys
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(Path(__file__).parent))
for package in ("franka", "trossen"):
    sys.path.insert(0, str(REPOSITORY / "plugins" / f"bt-manip-{package}" / "tests"))

from real_cell import CUBES, RealCell, write_model, write_scene  # noqa: E402
from simulation import ARM, MENAGERIE, start_franka  # noqa: E402

from tests.support.simulated_robot import SimulatedRobot  # noqa: E402


@pytest.fixture(scope="session")
def models():
    """Let ``menagerie:`` mean the folder of the models."""
    pytest.importorskip("pylibfranka")
    if not os.environ.get("FRANKA_SIM_PYTHON"):
        pytest.skip("FRANKA_SIM_PYTHON names no Python with franka-sim: see make rehearsal")
    if not ARM.is_file():
        pytest.skip(f"no model of MuJoCo Menagerie at {ARM}")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MENAGERIE_ROOT", str(MENAGERIE))
        yield


@pytest.fixture(scope="session")
def scene(models, tmp_path_factory) -> Path:
    """A scene file with a table, a basket and `CUBES` cubes to come."""
    path = tmp_path_factory.mktemp("scene") / "scene.toml"
    write_scene(path, CUBES)
    return path


@pytest.fixture(scope="session")
def real(scene) -> tuple[Path, RealCell]:
    """The model of the real cell, and what is in it."""
    model = scene.with_name("real.xml")
    return model, write_model(scene, ARM, model)


@pytest.fixture(scope="module")
def start_simulator(tmp_path_factory):
    """Start simulated robots, which end with the tests of a file: each takes a third of a core."""
    started = []

    def start(make, *options, **model) -> SimulatedRobot:
        started.append(make(tmp_path_factory.mktemp("robot") / "log", *options, **model))
        return started[-1]

    yield start
    for robot in started:
        robot.end()


@pytest.fixture(scope="module")
def start_robot(models, start_simulator):
    """Start simulated robots, which end with the tests of a file: each takes a third of a core."""
    return lambda model=ARM, *options: start_simulator(start_franka, *options, model=model)


@pytest.fixture(scope="module")
def robot(start_robot) -> SimulatedRobot:
    """A robot alone."""
    return start_robot()
