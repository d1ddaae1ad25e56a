"""Hooks of this package."""

from pathlib import Path

from bt_manip import hookimpl

ROBOTS = Path(__file__).parent / "robots"


@hookimpl
def register_grippers(register):
    """Register the hand."""
    from bt_manip_hands.hand import Hand

    register(Hand.kind, Hand)


@hookimpl
def register_robots(register):
    """Register the robots; models are fetched on first use."""
    from bt_manip.robots import read_description

    for path in sorted(ROBOTS.glob("*.toml")):
        register(read_description(path))
