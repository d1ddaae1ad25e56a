"""The hook that the package declares; its plugin is the example of the README."""

import re
from pathlib import Path

import numpy as np
import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.plugins import load_plugins
from bt_manip_learn.envs import LearningTask

README = Path(__file__).resolve().parents[1] / "README.md"


@pytest.fixture
def parts(tmp_path, monkeypatch):
    """Load the example."""
    (code,) = re.findall(r"```python\n(.*?register_actions.*?)```", README.read_text(), re.DOTALL)
    (tmp_path / "of_register_actions.py").write_text(code)
    monkeypatch.setenv("BT_MANIP_PLUGINS_DIR", str(tmp_path))
    return load_plugins(warn=pytest.fail).parts


def test_register_actions_makes_kinds_by_which_agents_act(parts):
    task = LearningTask("pick_place", action="joint_velocities", parts=parts)
    task.reset(0)
    arm = task.episodes.station.arm
    start = arm.q.copy()
    v = np.zeros(arm.model.nq)
    v[0] = 0.2
    for _ in range(20):
        task.step(v)
    assert (arm.q - start)[0] == pytest.approx(0.2, abs=0.03)  # a second with 0.2 rad/s
    np.testing.assert_allclose(task.action.recorded(), v, atol=1e-6)
    with pytest.raises(BtManipError, match="unknown action kind 'joint_velocity'; did you mean"):
        LearningTask("pick_place", action="joint_velocity", parts=task.episodes.parts)
