"""Where the models are."""

import os
from pathlib import Path

import pytest

HAND, ARM = "wonik_allegro", "universal_robots_ur5e"
_SHARED = Path(__file__).resolve().parents[4] / "shared"


@pytest.fixture(scope="module", autouse=True)
def menagerie(tmp_path_factory):
    """Let ``menagerie:`` mean a folder with arm and hand, or skip where one is missing.

    They are in the folder `MENAGERIE_ROOT`, or in one beside it with the suffix ``_more``.
    """
    root = Path(os.environ.get("MENAGERIE_ROOT", _SHARED / "menagerie"))
    folder = tmp_path_factory.mktemp("menagerie")
    for name in (HAND, ARM):
        found = [f / name for f in (root, root.with_name(f"{root.name}_more"))]
        found = [path for path in found if path.is_dir()]
        if not found:
            pytest.skip(f"no model {name} of MuJoCo Menagerie at {root}")
        (folder / name).symlink_to(found[0].resolve())
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MENAGERIE_ROOT", str(folder))
        yield folder
