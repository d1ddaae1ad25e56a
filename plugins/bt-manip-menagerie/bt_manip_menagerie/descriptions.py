"""The descriptions that travel with the package."""

from pathlib import Path


def description_files() -> list[Path]:
    """List the TOML files, one a robot, in alphabetical order."""
    return sorted((Path(__file__).parent / "robots").glob("*.toml"))
