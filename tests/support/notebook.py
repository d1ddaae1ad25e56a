"""What a notebook shows of a station, in which trees run."""

import re
from html import unescape
from typing import Any

import pytest

from bt_manip import build_station
from bt_manip.behaviours import RemoveObject, SpawnObject
from bt_manip.bt import Sequence, Sleep
from bt_manip.registry import Parts
from bt_manip.runner import Station


@pytest.fixture(scope="module")
def built(parts: Parts) -> tuple[Station, dict[str, Any]]:
    """Give a station and its state at the start."""
    station = build_station(parts)
    return station, station.get_state()


@pytest.fixture
def station(built: tuple[Station, dict[str, Any]]) -> Station:
    """Give the station in that state."""
    station, start = built
    station.set_state(start)
    return station


def words(html: str) -> str:
    """Return the text of HTML."""
    return " ".join(unescape(re.sub(r"<[^>]*>", " ", html)).split())


def visit() -> Sequence:
    """Return a tree in which a cube comes and goes."""
    return Sequence("visit", SpawnObject(object="{o}"), Sleep(msec=30), RemoveObject(object="{o}"))
