"""The program, run in the test's own process or at a terminal, and trees that are over at once."""

import json
import os
import select
import signal
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from bt_manip import plugins
from bt_manip.cli.interrupt import SIGNALS, Interrupt
from tests.support.program import bt_manip as bt_manip
from tests.support.program import task as task
from tests.support.program import trees as trees
from tests.support.terminal import terminal as terminal


@pytest.fixture(scope="session", autouse=True)
def hang_up_is_not_ignored() -> Iterator[None]:
    """Let SIGHUP act as in a terminal, also where the tests run under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture
def interrupt() -> Iterator[Interrupt]:
    """Give the handler of signals, and put the earlier ones back."""
    numbers = [getattr(signal, name) for name in (*SIGNALS, "SIGALRM")]
    before = {number: signal.getsignal(number) for number in numbers}
    interrupt = Interrupt()
    interrupt.install()
    yield interrupt
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def screen(monkeypatch) -> Iterator[Callable[[], Callable[[], str]]]:
    """Make the standard output a terminal; give a function that reads what it has shown."""
    ours, theirs = os.openpty()

    def begin() -> Callable[[], str]:
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.setattr(sys, "stdout", os.fdopen(theirs, "w"))
        return shown

    def shown() -> str:
        sys.stdout.flush()
        data = b""
        while select.select([ours], [], [], 0.0)[0]:
            data += os.read(ours, 65536)
        return data.decode()

    yield begin
    os.close(ours)


@pytest.fixture(autouse=True)
def commands_share_stations(shared_stations) -> None:
    """Let commands run in the stations of the tests before."""


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Give the folder of the test, in which its commands run."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def write(folder) -> Callable[..., str]:
    """Write a file into the folder of the test; give its name."""

    def write(text: str, name: str = "tree.xml") -> str:
        (folder / name).write_text(text)
        return name

    return write


@pytest.fixture
def digest(bt_manip, tmp_path) -> Callable[..., tuple[str, str]]:
    """Run a tree that succeeds; give the digest of its last state, and its warnings."""

    def run(tree: str, *options: object) -> tuple[str, str]:
        report = tmp_path / "report.json"
        code, _, err = bt_manip("run", tree, "--report", report, *options)
        assert code == 0, err
        return json.loads(report.read_text())["state_digest"], err

    return run


@pytest.fixture(scope="session")
def loaded_plugins() -> dict[Any, plugins.Plugins]:
    return {}


@pytest.fixture(autouse=True)
def commands_share_plugins(loaded_plugins, monkeypatch) -> None:
    """Let commands have the working plugins that one before has loaded; registries give copies."""
    load = plugins.load_plugins

    def load_once(*, choice: plugins.PluginSelection, **options: Any) -> plugins.Plugins:
        key = choice, tuple(sys.path)
        if key not in loaded_plugins:
            loaded = load(choice=choice, **options)
            if choice.folders or any(one.problem for one in loaded.plugins):
                return loaded
            loaded_plugins[key] = loaded
        return loaded_plugins[key]

    monkeypatch.setattr(plugins, "load_plugins", load_once)


@pytest.fixture
def site(tmp_path, monkeypatch, loaded_plugins):
    """Install packages of one module, with entry points."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)

    def install(name: str, source: str, entry_points: str):
        module = name.replace("-", "_")
        (folder / f"{module}.py").write_text(textwrap.dedent(source))
        info = folder / f"{module}-2.5.dist-info"
        info.mkdir(exist_ok=True)
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 2.5\n")
        (info / "entry_points.txt").write_text(textwrap.dedent(entry_points))
        loaded_plugins.clear()
        monkeypatch.delitem(sys.modules, module, raising=False)
        return folder

    return install
