"""Hooks of this package."""

from collections.abc import Callable
from pathlib import Path

from bt_manip import hookimpl

ROBOTS = Path(__file__).parent / "robots"


@hookimpl
def register_grippers(register: Callable[..., None]) -> None:
    """Register the hand and the suction cup."""
    from bt_manip_hands import Hand, SuctionGripper

    register(Hand.kind, Hand)
    register(SuctionGripper.kind, SuctionGripper)


@hookimpl
def register_robots(register: Callable[..., None]) -> None:
    """Register the robots; models are fetched on first use."""
    from bt_manip.robots import read_description

    for path in sorted(ROBOTS.glob("*.toml")):
        register(read_description(path))
