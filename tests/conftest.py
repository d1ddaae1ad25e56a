"""What all tests share: how mujoco draws, and where the models of others are."""

import gc
import os
from pathlib import Path
from typing import Any

import pytest

pytest_plugins = ["tests.support.drawing", "tests.robot_fixtures", "tests.support.runs"]

_REPOSITORY = Path(__file__).resolve().parent.parent

gc.disable()  # until all is collected: its passes over modules and tests take time


def pytest_collection_finish() -> None:
    """Spare the garbage collector the modules and tests, and let it run seldom."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    gc.enable()


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


@pytest.fixture(scope="session")
def menagerie() -> Path:
    """Give the folder of MuJoCo Menagerie, or skip the test where it is missing."""
    root = Path(os.environ.get("MENAGERIE_ROOT", _REPOSITORY.parent / "shared" / "menagerie"))
    if not root.is_dir():
        pytest.skip(f"no models of MuJoCo Menagerie at {root}")
    return root
