"""What all tests share: how mujoco draws, and where the models of others are."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

_REPOSITORY = Path(__file__).resolve().parent.parent
_PROBE = "import mujoco; mujoco.GLContext(16, 16).free()"


def _drawing_backend() -> str:
    """Find out, in a process of its own, which way of drawing without a display works here.

    mujoco and dm_control read MUJOCO_GL when they are imported, and with a backend that does not
    work dm_control does not import at all.
    """
    for backend in ("egl", "osmesa"):
        environment = {**os.environ, "MUJOCO_GL": backend}
        probe = subprocess.run(
            [sys.executable, "-c", _PROBE], env=environment, capture_output=True, check=False
        )
        if probe.returncode == 0:
            return backend
    return "disable"


if "MUJOCO_GL" not in os.environ:
    os.environ["MUJOCO_GL"] = _drawing_backend()


@pytest.fixture(scope="session")
def opengl() -> str:
    """Give the backend that draws, or skip the test where nothing can."""
    backend = os.environ["MUJOCO_GL"]
    if backend == "disable":
        pytest.skip("no OpenGL without a display here: neither EGL nor OSMesa can be loaded")
    return backend


@pytest.fixture(scope="session")
def menagerie() -> Path:
    """Give the folder of MuJoCo Menagerie, or skip the test where it is missing."""
    root = Path(os.environ.get("MENAGERIE_ROOT", _REPOSITORY.parent / "shared" / "menagerie"))
    if not root.is_dir():
        pytest.skip(f"no models of MuJoCo Menagerie at {root}")
    return root
