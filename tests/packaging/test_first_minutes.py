"""What a newcomer does in the first minutes: clone and run."""

import os
import subprocess
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
OURS = ("PYTHONPATH", "MUJOCO_GL", "DISPLAY", "VIRTUAL_ENV")


@pytest.mark.soak
@pytest.mark.parametrize("installer", ["pip", "uv"])
def test_make_run_sets_up_and_picks_a_cube_in_80_columns(tmp_path, installer):
    subprocess.run(["git", "clone", "--quiet", REPOSITORY, tmp_path / "clone"], check=True)
    environment = {name: value for name, value in os.environ.items() if name not in OURS}
    environment |= {"COLUMNS": "80", "INSTALLER": installer}
    how = {"cwd": tmp_path / "clone", "env": environment, "stdin": subprocess.DEVNULL}
    done = subprocess.run(["make", "run"], capture_output=True, text=True, **how)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert "1 of 1 cycles succeeded, goal met in 1" in done.stdout
    before = lines[: lines.index(".venv/bin/bt-manip run pick_place")]
    assert len(before) <= 4  # the steps of the setup, and nothing of pip
    assert "Warning" not in done.stderr
