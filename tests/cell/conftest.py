"""The built-in parts."""

import pytest

from bt_manip.plugins import load_plugins
from bt_manip.registry import Parts


@pytest.fixture(scope="session")
def parts() -> Parts:
    return load_plugins(entry_points=()).parts
