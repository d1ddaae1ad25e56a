"""Where the objectives and the models are."""

import os
from pathlib import Path

import pytest

from bt_manip.plugins import load_plugins
from bt_manip_moveit_pro.objectives import Workspace

SHARED = Path(__file__).resolve().parents[4] / "shared"
MODELS = ("universal_robots_ur5e", "robotiq_2f85", "kinova_gen3")


@pytest.fixture(scope="session")
def menagerie(tmp_path_factory):
    """Let ``menagerie:`` mean a folder with the models, or skip where one is missing.

    They are in the folder `MENAGERIE_ROOT`, or in one beside it with the suffix ``_more``.
    """
    root = Path(os.environ.get("MENAGERIE_ROOT", SHARED / "menagerie"))
    folder = tmp_path_factory.mktemp("menagerie")
    for name in MODELS:
        found = [f / name for f in (root, root.with_name(f"{root.name}_more"))]
        found = [path for path in found if path.is_dir()]
        if not found:
            pytest.skip(f"no model {name} of MuJoCo Menagerie at {root}")
        (folder / name).symlink_to(found[0].resolve())
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MENAGERIE_ROOT", str(folder))
        yield folder


@pytest.fixture(scope="session")
def parts():
    """Give the registered parts."""
    return load_plugins().parts


@pytest.fixture(scope="session")
def workspace(parts):
    """Give PickNik's public example workspace, or skip where it is missing."""
    root = Path(os.environ.get("MOVEIT_PRO_ROOT", SHARED / "moveit_pro"))
    if not root.is_dir():
        pytest.skip(f"no objectives of MoveIt Pro at {root}")
    return Workspace(root / "src", parts)
