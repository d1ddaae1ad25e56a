"""Where the objectives and the models are."""

import os
from pathlib import Path

import pytest

from bt_manip_moveit_pro.objectives import Workspace
from tests.support.models import SHARED, models_of_others


@pytest.fixture(scope="session")
def menagerie(tmp_path_factory):
    """Let ``menagerie:`` mean a folder with the models, or skip where they are missing."""
    robots = models_of_others("MENAGERIE_ROOT", "menagerie")
    more = models_of_others("MENAGERIE_MORE_ROOT", "menagerie_more")
    folder = tmp_path_factory.mktemp("menagerie")
    for path in (robots / "universal_robots_ur5e", robots / "robotiq_2f85", more / "kinova_gen3"):
        (folder / path.name).symlink_to(path.resolve())
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MENAGERIE_ROOT", str(folder))
        yield folder


@pytest.fixture(scope="session")
def workspace(parts):
    """Give PickNik's public example workspace, or skip where it is missing."""
    root = Path(os.environ.get("MOVEIT_PRO_ROOT", SHARED / "moveit_pro"))
    if not root.is_dir():
        pytest.skip(f"no objectives of MoveIt Pro at {root}")
    return Workspace(root / "src", parts)
