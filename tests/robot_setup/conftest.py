import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from bt_manip.robot_setup import reach

_SHARED = Path(__file__).resolve().parents[3] / "shared"


@pytest.fixture(scope="module", autouse=True)
def coarse_reach() -> Iterator[None]:
    """Measure the reach of robots at a quarter of the positions."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("_RADII", "_HEIGHTS"):
            patch.setattr(reach, name, getattr(reach, name)[1::2])
        yield


@pytest.fixture(scope="session")
def more_models() -> Path:
    """Give the folder of further models of MuJoCo Menagerie, or skip where it is missing."""
    root = Path(os.environ.get("MENAGERIE_MORE_ROOT", _SHARED / "menagerie_more"))
    if not root.is_dir():
        pytest.skip(f"no models of MuJoCo Menagerie at {root}")
    return root
