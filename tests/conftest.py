"""What all tests share."""

from typing import Any

import pytest

pytest_plugins = [
    "tests.support.garbage",
    "tests.support.drawing",
    "tests.support.models",
    "tests.robot_fixtures",
    "tests.support.runs",
]


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
