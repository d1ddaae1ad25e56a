"""Importing the library warns of nothing and sets nothing."""

import os
import subprocess
import sys

import pytest

CODE = "import os, bt_manip.runner; print(os.environ.get('MUJOCO_GL'))"


@pytest.mark.parametrize(
    "display", [pytest.param({}, marks=pytest.mark.soak), {"DISPLAY": ":9999"}]
)
def test_without_a_display_the_library_imports_silently_and_leaves_the_environment(display):
    environment = {k: v for k, v in os.environ.items() if k not in ("MUJOCO_GL", "DISPLAY")}
    done = subprocess.run(
        [sys.executable, "-c", CODE], env=environment | display, capture_output=True, text=True
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "None\n", "")
