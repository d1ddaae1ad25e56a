"""Models that need the package bt-manip-fuel."""

from pathlib import Path

from bt_manip.models.errors import ModelError
from bt_manip.models.formats import root_tag

FUEL_PLUGIN = "bt-manip-fuel"
"""Package with SDFormat and the models of Gazebo Fuel."""

_FUEL_KINDS = ("fuel", "http", "https")
_SDF_FILES = (".sdf", ".world")
_SDF_FOLDER = "model.config"


def check_fuel_plugin(address: str, kind: str = "", path: Path | None = None) -> None:
    """Raise an error that names the package for models which need bt-manip-fuel.

    Args:
        address: The address, for the message.
        kind: Kind of the address, if no source has it.
        path: The existing file or folder, if no format has it.

    Raises:
        ModelError: When it is a model of Fuel or SDFormat.
    """
    what = "Gazebo Fuel" if kind in _FUEL_KINDS else ""
    if path is not None and (
        path.suffix.lower() in _SDF_FILES
        or (path / _SDF_FOLDER).is_file()
        or root_tag(path) == "sdf"
    ):
        what = "SDFormat"
    if what:
        raise ModelError(
            f"'{address}': {what} needs the package {FUEL_PLUGIN}: pip install {FUEL_PLUGIN}"
        )
