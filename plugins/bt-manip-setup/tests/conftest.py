"""What the tests share: built-in parts, a coarse reach, and what tests of others share, too."""

from collections.abc import Iterator

import pytest

from bt_manip.registry import Parts
from tests.support.drawing import opengl as opengl
from tests.support.drawing import (
    processes_draw_if_their_test_does as processes_draw_if_their_test_does,
)
from tests.support.models import menagerie as menagerie
from tests.support.models import more_models as more_models
from tests.support.program import bt_manip as bt_manip


@pytest.fixture(scope="session")
def parts() -> Parts:
    """Give the built-in parts, without those of other packages that are installed."""
    from bt_manip import load_plugins

    return load_plugins(entry_points=()).parts


@pytest.fixture(scope="module", autouse=True)
def reach_is_coarse() -> Iterator[None]:
    """Measure the reach at few positions, with few initial guesses at each."""
    from bt_manip_setup import inspection, reach

    with pytest.MonkeyPatch.context() as patch:
        for module, name, coarse in (
            (reach, "_FEW", lambda count: 8),
            (reach, "_RADII", lambda grid: grid[1::2]),
            (reach, "_HEIGHTS", lambda grid: grid[1::3]),
            (inspection, "_X", lambda grid: grid[1::4]),
            (inspection, "_Y", lambda grid: grid[1::4]),
        ):
            patch.setattr(module, name, coarse(getattr(module, name)))
        yield
