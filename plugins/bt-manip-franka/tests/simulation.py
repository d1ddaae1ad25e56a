"""The simulated Franka."""

import os
from pathlib import Path

import pytest

from tests.support.models import SHARED
from tests.support.simulated_robot import SimulatedRobot

SERVER = Path(__file__).with_name("simulated_franka.py")
MENAGERIE = Path(os.environ.get("MENAGERIE_ROOT", SHARED / "menagerie"))
ARM = MENAGERIE / "franka_fr3" / "fr3.xml"


def start_franka(log: Path, *options: str, model: Path = ARM) -> SimulatedRobot:
    """Start franka-sim with a model of the arm, or of a cell; skip where models are missing."""
    hand = MENAGERIE / "franka_emika_panda" / "hand.xml"
    for path in (model, hand):
        if not path.is_file():
            pytest.skip(f"no model at {path}")
    models = {"FR3_MJCF": str(model), "FRANKA_HAND_MJCF": str(hand)}
    return SimulatedRobot(SERVER, "FRANKA_SIM_PYTHON", log, *options, variables=models)
