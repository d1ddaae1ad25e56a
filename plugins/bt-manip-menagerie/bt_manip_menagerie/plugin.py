"""Hooks of this package, and its descriptions."""

from collections.abc import Callable
from pathlib import Path

from bt_manip import hookimpl


def description_files() -> list[Path]:
    """List the TOML files, one for each robot, in alphabetical order."""
    return sorted((Path(__file__).parent / "robots").glob("*.toml"))


@hookimpl
def register_robots(register: Callable[..., None]) -> None:
    """Register the robots; models are fetched on first use."""
    from bt_manip.robots import read_description

    for path in description_files():
        register(read_description(path))
