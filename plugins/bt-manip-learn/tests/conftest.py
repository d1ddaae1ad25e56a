"""What the tests share: whether mujoco draws, and the program."""

import os
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any, NamedTuple

import pytest

PROBE = "import mujoco as m; m.Renderer(m.MjModel.from_xml_string('<mujoco/>'), 16, 16).close()"


def draws(backend: str) -> bool:
    """Find out, in a process of its own, whether a way of drawing works here."""
    environment = {**os.environ, "MUJOCO_GL": backend}
    probe = [sys.executable, "-c", PROBE]
    return subprocess.run(probe, env=environment, capture_output=True).returncode == 0


if "MUJOCO_GL" not in os.environ:  # dm_control reads it when it is imported
    os.environ["MUJOCO_GL"] = next(filter(draws, ("egl", "osmesa")), "disable")


@pytest.fixture(scope="session")
def opengl() -> str:
    """Give the backend that draws, or skip the test where none does."""
    backend = os.environ["MUJOCO_GL"]
    if not draws(backend):
        pytest.skip(f"no OpenGL to draw with here: MUJOCO_GL={backend}")
    return backend


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave the contracts that take seconds to soak, but for one kind of actions."""
    for item in items:
        kind, _, check = item.name.partition("[")[2].partition(": ")
        if "cartesian_deltas" != kind and check.startswith(("goes on from its", "has the same")):
            item.add_marker("soak")


class Outcome(NamedTuple):
    """What a command came to."""

    code: int
    out: str
    err: str


@pytest.fixture
def bt_manip(capfd: Any, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Outcome]:
    """Run a command and give what it came to."""
    (command,) = entry_points(group="console_scripts", name="bt-manip")

    def run(*arguments: object) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["bt-manip", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            sys.exit(command.load()())
        code = ended.value.code
        return Outcome(code if isinstance(code, int) else 0, *capfd.readouterr())

    return run
