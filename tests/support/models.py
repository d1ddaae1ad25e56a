"""Where the models of robots are."""

import os
from pathlib import Path

import mujoco
import pytest
from dm_control import mjcf

SHARED = Path(__file__).resolve().parents[3] / "shared"  # beside the checkout

ROBOTS = Path(__file__).with_name("robots")
"""Models and descriptions of arms that tests of several packages use."""


def compiled(root: mjcf.RootElement) -> mujoco.MjModel:
    """Compile a PyMJCF model."""
    return mujoco.MjModel.from_xml_string(root.to_xml_string(), root.get_assets())


def models_of_others(variable: str, folder: str) -> Path:
    """Return the folder of models that an environment variable names, or skip the test."""
    root = Path(os.environ.get(variable, SHARED / folder))
    if not root.is_dir():
        pytest.skip(f"no models of MuJoCo Menagerie at {root}")
    return root


@pytest.fixture(scope="session")
def menagerie() -> Path:
    """Give the folder of MuJoCo Menagerie, or skip the test where it is missing."""
    return models_of_others("MENAGERIE_ROOT", "menagerie")


@pytest.fixture(scope="session")
def more_models() -> Path:
    """Give the folder of further models of MuJoCo Menagerie, or skip where it is missing."""
    return models_of_others("MENAGERIE_MORE_ROOT", "menagerie_more")
