"""Environments of trees; skipped where Gymnasium is not installed."""

import pytest

pytest.importorskip("gymnasium", reason="Gymnasium is not installed: bt-manip[learn]")


@pytest.fixture(autouse=True)
def runs_share_stations(shared_stations) -> None:
    """Let runs have the stations of the tests before."""
