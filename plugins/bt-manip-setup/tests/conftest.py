"""What the tests share: built-in parts, models, a coarse reach, and the program."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from bt_manip.registry import Parts

from .program import Outcome, run_program

_SHARED = Path(__file__).resolve().parents[4] / "shared"
_PROBE = "import mujoco as m; m.Renderer(m.MjModel.from_xml_string('<mujoco/>'), 16, 16).close()"


def draws(backend: str) -> bool:
    """Find out, in a process of its own, whether a way of drawing works here."""
    environment = {**os.environ, "MUJOCO_GL": backend}
    probe = [sys.executable, "-c", _PROBE]
    return subprocess.run(probe, env=environment, capture_output=True).returncode == 0


_BACKEND = os.environ.get("MUJOCO_GL") or next(filter(draws, ("egl", "osmesa")), "disable")
os.environ["MUJOCO_GL"] = _BACKEND  # dm_control reads it when it is imported


@pytest.fixture(scope="session")
def opengl() -> str:
    """Give the backend that draws, or skip the test where none does."""
    if not draws(_BACKEND):
        pytest.skip(f"no OpenGL to draw with here: MUJOCO_GL={_BACKEND}")
    return _BACKEND


@pytest.fixture(autouse=True)
def processes_draw_if_their_test_does(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Let processes that a test starts draw only if the test asks for it."""
    if "opengl" not in request.fixturenames:
        monkeypatch.setenv("MUJOCO_GL", "disable")


@pytest.fixture(scope="session")
def parts() -> Parts:
    """Give the built-in parts, without those of other packages that are installed."""
    from bt_manip import load_plugins

    return load_plugins(entry_points=()).parts


@pytest.fixture(scope="module", autouse=True)
def reach_is_coarse() -> Iterator[None]:
    """Measure the reach of robots at a quarter of the positions."""
    from bt_manip_setup import reach

    with pytest.MonkeyPatch.context() as patch:
        for name in ("_RADII", "_HEIGHTS"):
            patch.setattr(reach, name, getattr(reach, name)[1::2])
        yield


def _models(variable: str, folder: str) -> Path:
    root = Path(os.environ.get(variable, _SHARED / folder))
    if not root.is_dir():
        pytest.skip(f"no models of MuJoCo Menagerie at {root}")
    return root


@pytest.fixture(scope="session")
def menagerie() -> Path:
    """Give the folder of MuJoCo Menagerie, or skip the test where it is missing."""
    return _models("MENAGERIE_ROOT", "menagerie")


@pytest.fixture(scope="session")
def more_models() -> Path:
    """Give the folder of further models of MuJoCo Menagerie, or skip where it is missing."""
    return _models("MENAGERIE_MORE_ROOT", "menagerie_more")


@pytest.fixture
def bt_manip(capfd: Any) -> Callable[..., Outcome]:
    """Run a command and give what it came to."""

    def run(*arguments: object) -> Outcome:
        code = run_program(*arguments)
        return Outcome(code, *capfd.readouterr())

    return run
