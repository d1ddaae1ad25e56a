"""Plugins that exist only for a test."""

import itertools
import textwrap
from collections.abc import Callable
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import pytest

from bt_manip import hookimpl
from bt_manip.plugins import Plugins, load_plugins

_numbers = itertools.count()


class TinyBuiltin:
    """Stands in for the built-in plugin: one object, without robots or physics."""

    @hookimpl
    def register_objects(self, register: Callable[..., None]) -> None:
        register("cube", dict)


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., EntryPoint]:
    """Write a plugin's module and give its entry point."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(name: str, source: str) -> EntryPoint:
        module = f"tiny_plugin_{next(_numbers)}"
        (tmp_path / f"{module}.py").write_text(
            "from bt_manip import hookimpl\n" + textwrap.dedent(source)
        )
        return EntryPoint(name, module, "bt_manip")

    return write


@pytest.fixture
def load() -> Callable[..., tuple[Plugins, list[str]]]:
    """Load the tiny built-in plugin and some others; give the warnings too."""

    def load_all(*points: EntryPoint, builtin: Any = None) -> tuple[Plugins, list[str]]:
        warnings: list[str] = []
        plugins = load_plugins(
            entry_points=points, builtin=builtin or TinyBuiltin(), warn=warnings.append
        )
        return plugins, warnings

    return load_all
