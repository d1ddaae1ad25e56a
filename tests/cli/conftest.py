"""The program, run in the test's own process or at a terminal, and trees that are over at once."""

import signal
import sys
from collections.abc import Iterator
from typing import Any

import pytest

from bt_manip import plugins
from tests.support.program import bt_manip as bt_manip
from tests.support.program import trees as trees
from tests.support.terminal import terminal as terminal


@pytest.fixture(scope="session", autouse=True)
def hang_up_is_not_ignored() -> Iterator[None]:
    """Let SIGHUP act as in a terminal, also where the tests run under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.fixture(autouse=True)
def commands_share_stations(shared_stations) -> None:
    """Let commands run in the stations of the tests before."""


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
