import os
from pathlib import Path

import pytest

_SHARED = Path(__file__).resolve().parents[3] / "shared"


@pytest.fixture(scope="module", autouse=True)
def reach_is_coarse(coarse_reach) -> None:
    """Measure the reach of robots at a quarter of the positions."""


@pytest.fixture(scope="session")
def more_models() -> Path:
    """Give the folder of further models of MuJoCo Menagerie, or skip where it is missing."""
    root = Path(os.environ.get("MENAGERIE_MORE_ROOT", _SHARED / "menagerie_more"))
    if not root.is_dir():
        pytest.skip(f"no models of MuJoCo Menagerie at {root}")
    return root
