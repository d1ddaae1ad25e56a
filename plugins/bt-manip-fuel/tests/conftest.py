"""A running Fuel server, and its cache."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from bt_manip_fuel.fuel.cache import FuelCache
from tests.support.program import bt_manip as bt_manip

from .fuel_server import FuelServer


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[FuelServer]:
    """Give a running server that ``fuel:`` means, with an empty cache."""
    running = FuelServer()
    monkeypatch.setenv("BT_MANIP_FUEL_URL", running.url)
    monkeypatch.setenv("GZ_FUEL_CACHE_PATH", str(tmp_path / "cache"))
    monkeypatch.setenv("BT_MANIP_CACHE", str(tmp_path / "own_cache"))
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    monkeypatch.delenv("BT_MANIP_FUEL_TOKEN", raising=False)
    yield running
    running.stop()


@pytest.fixture
def other_server() -> Iterator[FuelServer]:
    running = FuelServer()
    yield running
    running.stop()


@pytest.fixture
def cache(server: FuelServer) -> FuelCache:
    """Give the cache in which models of the server are kept."""
    return FuelCache()
