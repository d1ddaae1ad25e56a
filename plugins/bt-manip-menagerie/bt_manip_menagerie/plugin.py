"""Hooks of this package, and the descriptions that travel with it."""

from pathlib import Path

from bt_manip import hookimpl


def description_files() -> list[Path]:
    """List the TOML files, one a robot, in alphabetical order."""
    return sorted((Path(__file__).parent / "robots").glob("*.toml"))


@hookimpl
def register_robots(register):
    """Bring the robots; their models are fetched when one of them is used."""
    from bt_manip.robots import read_description

    for path in description_files():
        register(read_description(path))
