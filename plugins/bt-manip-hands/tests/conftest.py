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
