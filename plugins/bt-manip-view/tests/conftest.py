"""What the tests share: drawing, runs in stations of their own, and the program."""

import os
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

PROBE = "import mujoco as m; m.Renderer(m.MjModel.from_xml_string('<mujoco/>'), 16, 16).close()"

TREES = """
    from bt_manip.behaviours import ObjectExists
    from bt_manip.bt import Action, Sequence, Sleep


    class Shout(Action):
        def update(self):
            raise ValueError("so loud")


    def quick(name="table"):
        return Sequence("quick", [ObjectExists(object=name), Sleep("rest", msec=20)])


    def failing():
        return Sequence("failing", [Sleep("rest", msec=20), ObjectExists("look", object="no")])


    def endless():
        return Sleep("rest", msec=10_000_000)


    def loud():
        return Sequence("loud", [Sleep("rest", msec=20), Shout()])
"""


def draws(backend: str) -> bool:
    """Find out, in a process of its own, whether a way of drawing works here."""
    environment = {**os.environ, "MUJOCO_GL": backend}
    probe = [sys.executable, "-c", PROBE]
    return subprocess.run(probe, env=environment, capture_output=True).returncode == 0


if "MUJOCO_GL" not in os.environ:  # dm_control reads it when it is imported
    os.environ["MUJOCO_GL"] = next(filter(draws, ("egl", "osmesa")), "disable")
BACKEND = os.environ["MUJOCO_GL"]

import dm_control.mujoco  # noqa: E402, F401 it reads MUJOCO_GL

from bt_manip.bt import Node, Tree  # noqa: E402
from bt_manip.cli import Interrupt, run_app  # noqa: E402
from bt_manip.registry import Parts  # noqa: E402
from bt_manip.runner import Run, RunRequest, TreeSource, make_station  # noqa: E402
from bt_manip.scenes import Scene  # noqa: E402


@pytest.fixture(autouse=True)
def processes_draw_if_their_test_does(request, monkeypatch) -> None:
    """Let processes that a test starts load no OpenGL, unless the test asks for it."""
    if "opengl" not in request.fixturenames:
        monkeypatch.setenv("MUJOCO_GL", "disable")


@pytest.fixture(scope="session")
def opengl() -> str:
    """Give the backend that draws, or skip the test where none does."""
    if not draws(BACKEND):
        pytest.skip(f"no OpenGL to draw with here: MUJOCO_GL={BACKEND}")
    return BACKEND


@pytest.fixture(scope="session")
def make_run(parts: Parts) -> Callable[..., Run]:
    """Make a run of a tree; options that are not named here are those of its request."""

    def make(root: Node, *, scene: Scene | None = None, seed: int = 0, **request: Any) -> Run:
        source = TreeSource("test", "python")
        chosen = {} if scene is None else {"scene": scene}
        station = make_station(RunRequest(source, seed=seed, **chosen), parts)
        tree = Tree(root, clock=station.clock)
        tree.setup(**station.infrastructure)
        return Run(RunRequest(source, seed=seed, **request), tree, station)

    return make


@pytest.fixture(scope="session")
def picked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record two cycles of pick_place once, with the report beside the recording."""
    path = tmp_path_factory.mktemp("picked") / "run.mcap"
    command = ["run", "pick_place", "--cycles", "2", "--quiet", "--record", str(path)]
    assert run_app(Interrupt(), [*command, "--report", str(path.with_suffix(".json"))]) == 0
    return path


class Outcome(NamedTuple):
    """What a command came to."""

    code: int
    out: str
    err: str


@pytest.fixture
def bt_manip(capfd: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """Run a command and give what it came to."""

    def run(*arguments: object) -> Outcome:
        code = run_app(Interrupt(), [str(argument) for argument in arguments])
        out, err = capfd.readouterr()
        return Outcome(code, out, err)

    return run


@pytest.fixture
def trees(tmp_path: Path) -> Path:
    """Give a file with small trees."""
    path = tmp_path / "small_trees.py"
    path.write_text(textwrap.dedent(TREES))
    return path
