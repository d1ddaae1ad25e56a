"""The program, run inside the test's own process, and trees that are over at once."""

import os
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from bt_manip.cli import Interrupt, run_app

DEVICES = Path(__file__).parent / "devices"
"""Folder of a plugin that drives arms which are not there."""

TREES = """
    from bt_manip.behaviours import ObjectExists
    from bt_manip.bt import Action, Delay, Fallback, Sequence, Sleep, Status


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


    def broken():
        raise RuntimeError("no tree today")


    def no_tree():
        return 3
"""


class Outcome(NamedTuple):
    """What a command came to."""

    code: int
    out: str
    err: str


def run_program(*arguments: object) -> int:
    """Run a command; return its exit code."""
    return run_app(Interrupt(), [str(argument) for argument in arguments])


def run_python(*arguments: object, cwd: Path, **variables: str) -> str:
    """Run Python in a process of its own and return what it printed."""
    done = subprocess.run(
        [sys.executable, *map(str, arguments)], cwd=cwd, capture_output=True, text=True,
        env={**os.environ, **variables}, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def trees(tmp_path: Path) -> Path:
    """Give a file with small trees."""
    path = tmp_path / "small_trees.py"
    path.write_text(textwrap.dedent(TREES))
    return path


@pytest.fixture
def task(tmp_path: Path) -> Callable[..., Path]:
    """Write ``task.xml``, whose line 2 has the attributes of the tree, and 3 its root node."""

    def write(root: str, attributes: str = "") -> Path:
        path = tmp_path / "task.xml"
        path.write_text(
            '<root BTCPP_format="4" main_tree_to_execute="Main">\n'
            f'<BehaviorTree ID="Main" {attributes}>\n{root}\n</BehaviorTree></root>'
        )
        return path

    return write


@pytest.fixture
def bt_manip(
    capfd: pytest.CaptureFixture[str], request: pytest.FixtureRequest
) -> Callable[..., Outcome]:
    """Run a command and give what it came to; with shared stations, the next one has its."""
    shared = "shared_stations" in request.fixturenames
    pool = request.getfixturevalue("station_pool") if shared else None

    def run(*arguments: object) -> Outcome:
        code = run_program(*arguments)
        if pool is not None:
            pool.release()
        return Outcome(code, *capfd.readouterr())

    return run
