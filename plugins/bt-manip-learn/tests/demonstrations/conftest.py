"""Demonstrations of an arm of two joints, which no physics has seen."""

import numpy as np
import pytest

from bt_manip_learn.demonstrations import Demonstration, DemonstrationStore

STEPS = 5


def described(names, bound):
    """Describe a kind of actions with the same bound for all numbers."""
    low, high = [-bound] * len(names), [bound] * len(names)
    return {"names": names, "units": ["-"] * len(names), "low": low, "high": high}


IDENTITY = {
    "tree": "pick",
    "task": "pick the cube up",
    "varied": {"scene.mass": 2},
    "step_s": 0.05,
    "robot": "panda, ur5e",  # those of the robots: the scene names one of them
    "controller": "computed_torque",
    "planner": "lazy",
    "request": {"robot": "panda", "controller": "computed_torque", "planner": "lazy"},
    "scene": "table_and_basket",
    "settings": {"cube": "auto"},
    "images": {"kinds": []},
    "tick_s": 0.05,
    "observations": {
        "joint_positions": {"group": "robot"},
        "overview_rgb": {"group": "robot"},
        "cube_position": {"group": "simulator"},
    },
    "actions": {
        "joint_targets": described("abc", 4.0),
        "cartesian_deltas": described("abcdefg", 2.0),
    },
}


@pytest.fixture
def make_demonstration():
    def make(episode=0, steps=STEPS, success=True):
        rng = np.random.default_rng(episode)
        return Demonstration(
            episode,
            success,
            "" if success else "pick/Grasp: it slipped",
            f"{episode:064}",
            {
                "joint_positions": rng.normal(size=(steps + 1, 2)),
                "cube_position": rng.normal(size=(steps + 1, 3)),
                "overview_rgb": rng.integers(0, 256, (steps + 1, 8, 12, 3), dtype=np.uint8),
            },
            {
                "joint_targets": rng.normal(size=(steps, 3)),
                "cartesian_deltas": rng.normal(size=(steps, 7)),
            },
            rng.normal(size=steps),
            np.arange(steps) == steps - 1,
            rng.normal(size=(steps + 1, 9)),
            ("pick/Reach", "pick/Grasp", "pick/Lift", "pick/Lift", "")[:steps],
            rng.integers(0, 4, (steps, 6), dtype=np.uint8),
            "pick the red cube up" if episode == 1 else "",  # otherwise that of the manifest
        )

    return make


@pytest.fixture
def store(tmp_path, make_demonstration):
    """Three demonstrations, and the file of an episode that failed."""
    store = DemonstrationStore.create(tmp_path / "demos", IDENTITY)
    for episode in (0, 1, 3):
        store.write(make_demonstration(episode))
    store.write(make_demonstration(2, steps=0, success=False))
    return store
