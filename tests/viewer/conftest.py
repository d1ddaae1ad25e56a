"""Stations that one test after another has."""

import pytest


@pytest.fixture(autouse=True)
def tests_share_stations(shared_stations, station_pool, monkeypatch) -> None:
    """Let runs and tests have the stations of the tests before."""
    monkeypatch.setattr("bt_manip.plugins.stations.make_station", station_pool.build)
