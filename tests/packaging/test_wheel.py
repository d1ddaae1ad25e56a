"""The wheel has everything; test_commands_of_pages.py runs it apart from the sources."""

import subprocess
import sys
import zipfile
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]


def test_trees_and_models_travel_in_the_wheel(tmp_path):
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", tmp_path]
    done = subprocess.run(
        [*command, REPOSITORY], capture_output=True, text=True, stdin=subprocess.DEVNULL
    )
    assert done.returncode == 0, done.stdout + done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    packed = set(zipfile.ZipFile(wheel).namelist())
    for folder in ("trees", "models"):
        for path in (REPOSITORY / folder).rglob("*.xml"):
            assert f"bt_manip/bundled/{path.relative_to(REPOSITORY).as_posix()}" in packed
    for path in (REPOSITORY / "scenes").glob("*.toml"):
        assert f"bt_manip/bundled/scenes/{path.name}" in packed
    assert not [name for name in packed if "__pycache__" in name]
    assert "bt_manip/py.typed" in packed
    assert any(name.endswith("licenses/LICENSE") for name in packed)
    tops = {name.partition("/")[0] for name in packed}
    assert tops == {"bt_manip", next(top for top in tops if top.endswith(".dist-info"))}
