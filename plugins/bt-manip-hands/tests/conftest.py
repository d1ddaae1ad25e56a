"""Where the models of the hand are."""

import os
from pathlib import Path

import pytest

from tests.support.models import SHARED
from tests.support.models import menagerie as menagerie

HAND, ARM = "wonik_allegro", "universal_robots_ur5e"


@pytest.fixture(scope="module")
def hand_models(menagerie, tmp_path_factory):
    """Let ``menagerie:`` mean a folder with arm and hand, or skip where one is missing."""
    more = Path(os.environ.get("MENAGERIE_MORE_ROOT", SHARED / "menagerie_more"))
    folder = tmp_path_factory.mktemp("menagerie")
    for name in (HAND, ARM):
        found = [path for one in (menagerie, more) if (path := one / name).is_dir()]
        if not found:
            pytest.skip(f"no model {name} of MuJoCo Menagerie at {menagerie}")
        (folder / name).symlink_to(found[0].resolve())
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MENAGERIE_ROOT", str(folder))
        yield folder


@pytest.fixture
def check_held():
    """Give a check that all know of the held object, and that a state continues to the last bit."""

    def check(station):
        world = station.arm.world
        world.refresh()
        assert world.held == "thing" and not world.collisions(station.robot.q)
        summary = station.cell.contact_monitor.summary()
        assert summary.unexpected == () and summary.held == ("thing",)
        state, ends = station.get_state(), []
        for _ in range(2):
            station.cell.step(100)
            ends.append(station.cell.state_bytes())
            station.set_state(state)
        assert ends[0] == ends[1]

    return check
