"""Where the models are, and one compiled station for each robot."""

from functools import cache

import pytest

from bt_manip import build_station
from bt_manip.runner import Station
from tests.support.models import models_of_others

ROBOTS = ("fr3", "iiwa14", "menagerie_panda", "ur5e", "xarm7")


@pytest.fixture(scope="session", autouse=True)
def menagerie():
    """Let ``menagerie:`` mean a folder on this machine, or skip where there is none."""
    root = models_of_others("MENAGERIE_ROOT", "menagerie")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MENAGERIE_ROOT", str(root))
        yield root


@cache
def _station(robot: str) -> Station:
    return build_station(robot=robot)


@pytest.fixture(scope="session", params=ROBOTS)
def station(request) -> Station:
    """Give a robot beside table and basket; each once a session, as its meshes take their time."""
    return _station(request.param)
