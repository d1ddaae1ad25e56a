"""Hooks of this package."""

import importlib.util
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from bt_manip import hookimpl

MODEL = "wxai_follower.xml"


def model_folder() -> Path:
    """Return the folder of the arm's model: ``TROSSEN_ARM_ASSETS``, or that of trossen-arm-sim."""
    if folder := os.environ.get("TROSSEN_ARM_ASSETS"):
        return Path(folder)
    found = importlib.util.find_spec("trossen_arm_sim")
    places = found.submodule_search_locations if found is not None else None
    return Path(*(places or ["trossen_arm_sim (set TROSSEN_ARM_ASSETS)"])) / "assets"


@hookimpl
def register_robots(register: Callable[..., None]) -> None:
    """Register the arm; its model is not part of this package."""
    from bt_manip.robots import read_description

    description = read_description(Path(__file__).with_name("widowx_ai.toml"))
    register(replace(description, model=str(model_folder() / MODEL)))


@hookimpl
def register_backends(register: Callable[..., None]) -> None:
    """Register the backend; the driver is imported in the process that speaks to the arm."""
    from bt_manip.robots import Backend

    register(
        "trossen",
        Backend(
            arm="bt_manip_trossen.arm:WidowXAI",
            controllers=("position",),
            address="the IP address of the arm's controller, such as 192.168.1.2",
        ),
    )
