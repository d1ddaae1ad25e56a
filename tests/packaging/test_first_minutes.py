"""What a newcomer does in the first minutes: clone, run, complete a name, make mistakes."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.soak


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("newcomer") / "bt-manip"
    subprocess.run(["git", "clone", "--quiet", REPOSITORY, path], check=True)
    return path


def run(clone: Path, *command: str, **variables: str) -> subprocess.CompletedProcess:
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in ("PYTHONPATH", "MUJOCO_GL", "DISPLAY", "VIRTUAL_ENV")
    }
    return subprocess.run(
        command, cwd=clone, env={**environment, "COLUMNS": "80", **variables},
        capture_output=True, text=True, stdin=subprocess.DEVNULL,
    )  # fmt: skip


@pytest.mark.parametrize("installer", ["pip", "uv"])
def test_make_run_sets_up_and_picks_a_cube_in_80_columns(clone, installer):
    shutil.rmtree(clone / ".venv", ignore_errors=True)
    done = run(clone, "make", "run", INSTALLER=installer)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert "1 of 1 cycles succeeded, goal met in 1" in done.stdout
    before = lines[: lines.index(".venv/bin/bt-manip run pick_place")]
    assert len(before) <= 4  # the steps of the setup, and nothing of pip
    assert "Warning" not in done.stderr


def test_a_tree_is_completed(clone):
    done = run(
        clone, ".venv/bin/bt-manip",
        _BT_MANIP_COMPLETE="bash_complete", COMP_WORDS="bt-manip run pi", COMP_CWORD="2",
    )  # fmt: skip
    assert "plain,pick_place" in done.stdout.splitlines()
