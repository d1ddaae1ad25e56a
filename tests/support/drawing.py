"""How mujoco draws in tests; imported before mujoco."""

import os
import subprocess
import sys

import pytest

PROBE = "import mujoco as m; m.Renderer(m.MjModel.from_xml_string('<mujoco/>'), 16, 16).close()"


def draws(backend: str) -> bool:
    """Find out, in a process of its own, whether a way of drawing works here.

    mujoco and dm_control read MUJOCO_GL when they are imported, and with a backend that does not
    work dm_control does not import at all.
    """
    environment = {**os.environ, "MUJOCO_GL": backend}
    probe = [sys.executable, "-c", PROBE]
    return subprocess.run(probe, env=environment, capture_output=True).returncode == 0


if "MUJOCO_GL" not in os.environ:
    os.environ["MUJOCO_GL"] = next(filter(draws, ("egl", "osmesa")), "disable")
BACKEND = os.environ["MUJOCO_GL"]


@pytest.fixture(autouse=True)
def processes_draw_if_their_test_does(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Let processes that a test starts load no OpenGL, unless the test asks for it."""
    if "opengl" not in request.fixturenames:
        monkeypatch.setenv("MUJOCO_GL", "disable")


@pytest.fixture(scope="session")
def opengl() -> str:
    """Give the backend that draws, or skip the test where it does not."""
    if not draws(BACKEND):
        pytest.skip(f"no OpenGL to draw with here: MUJOCO_GL={BACKEND} does not work")
    return BACKEND
