"""What all tests share."""

import gc
import os
from pathlib import Path
from typing import Any

import pytest

pytest_plugins = [
    "tests.support.drawing",
    "tests.support.models",
    "tests.robot_fixtures",
    "tests.support.runs",
]

GARBAGE = 400e6
"""Memory that may grow until what tests have left in cycles is collected, such as stations [B]."""

STATM = Path("/proc/self/statm")

gc.disable()  # until all is collected: its passes over modules and tests take time


def pytest_collection_finish() -> None:
    """Spare the garbage collector the modules and tests, and let it run seldom."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    gc.enable()


def _memory() -> int:
    """Return the resident memory of this process, as far as it is known [B]."""
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") if STATM.exists() else 0


_kept = _memory()


def pytest_runtest_logfinish() -> None:
    """Collect garbage once it takes much memory: each station of 10 MB is a cycle."""
    global _kept
    if _memory() > _kept + GARBAGE:
        gc.collect()
        _kept = _memory()


def pytest_unconfigure() -> None:
    """Leave nothing for the end of Python, when libraries report it as leaked."""
    gc.unfreeze()
    gc.collect()


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
