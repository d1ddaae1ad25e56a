"""What all tests share: how mujoco draws, and where the models of others are."""

import gc
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

pytest_plugins = ["tests.robot_fixtures", "tests.run_fixtures"]

_REPOSITORY = Path(__file__).resolve().parent.parent
_PROBE = "import mujoco as m; m.Renderer(m.MjModel.from_xml_string('<mujoco/>'), 16, 16).close()"


gc.disable()  # until all is collected: its passes over modules and tests take time


def pytest_collection_finish() -> None:
    """Spare the garbage collector the modules and tests, and let it run seldom."""
    import dm_control.mujoco  # noqa: F401 it reads MUJOCO_GL, which tests change

    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    gc.enable()


def pytest_unconfigure() -> None:
    """Leave nothing for the end of Python, when libraries report it as leaked."""
    gc.unfreeze()
    gc.collect()


def _draws(backend: str) -> bool:
    """Find out, in a process of its own, whether a way of drawing works here.

    mujoco and dm_control read MUJOCO_GL when they are imported, and with a backend that does not
    work dm_control does not import at all.
    """
    environment = {**os.environ, "MUJOCO_GL": backend}
    probe = subprocess.run(
        [sys.executable, "-c", _PROBE], env=environment, capture_output=True, check=False
    )
    return probe.returncode == 0


if "MUJOCO_GL" not in os.environ:
    os.environ["MUJOCO_GL"] = next(filter(_draws, ("egl", "osmesa")), "disable")
_BACKEND = os.environ["MUJOCO_GL"]


@pytest.fixture(autouse=True)
def processes_draw_if_their_test_does(request, monkeypatch) -> None:
    """Let processes that a test starts load no OpenGL, unless the test asks for it."""
    if "opengl" not in request.fixturenames:
        monkeypatch.setenv("MUJOCO_GL", "disable")


@pytest.fixture(scope="session")
def parts() -> Any:
    """Give the built-in parts; the fixture of this name that users have has all installed ones."""
    from bt_manip.plugins import load_plugins

    return load_plugins(entry_points=()).parts


@pytest.fixture(scope="session")
def build_station(parts: Any) -> Any:
    """Build stations of the built-in parts, apart from those of the tests of plugins/."""
    from bt_manip import build_station

    return lambda: build_station(parts)


@pytest.fixture(scope="session")
def opengl() -> str:
    """Give the backend that draws, or skip the test where it does not."""
    if not _draws(_BACKEND):
        pytest.skip(
            "no OpenGL to draw with here: neither EGL nor OSMesa works"
            if _BACKEND == "disable"
            else f"no OpenGL to draw with here: MUJOCO_GL={_BACKEND} does not work"
        )
    return _BACKEND


@pytest.fixture(scope="session")
def menagerie() -> Path:
    """Give the folder of MuJoCo Menagerie, or skip the test where it is missing."""
    root = Path(os.environ.get("MENAGERIE_ROOT", _REPOSITORY.parent / "shared" / "menagerie"))
    if not root.is_dir():
        pytest.skip(f"no models of MuJoCo Menagerie at {root}")
    return root
