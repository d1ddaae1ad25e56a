"""The simulated WidowX AI."""

from pathlib import Path

from tests.support.simulated_robot import SimulatedRobot

SERVER = Path(__file__).with_name("simulated_widowx.py")


def start_widowx(log: Path, *model: Path) -> SimulatedRobot:
    """Start trossen-arm-sim with the model of a cell, by default the arm alone."""
    return SimulatedRobot(SERVER, "TROSSEN_SIM_PYTHON", log, *model)
