"""Client of a Fuel server."""

import os
from pathlib import Path

from bt_manip.models import ModelError, Progress, check_downloads, terminal_progress
from bt_manip_fuel.fuel.address import FuelAddress
from bt_manip_fuel.fuel.archive import unpack
from bt_manip_fuel.fuel.cache import FuelCache
from bt_manip_fuel.fuel.transfer import open_zip, save
from bt_manip_fuel.model_config import sdf_file

TOKEN_VARIABLE = "BT_MANIP_FUEL_TOKEN"
"""Environment variable with the token for private models."""


def find_model(
    address: FuelAddress, progress: Progress = terminal_progress
) -> tuple[FuelAddress, Path]:
    """Return a model, from the cache if it has the requested version (or any).

    Args:
        address: The model.
        progress: Called with the progress of a download.

    Returns:
        The address with the version, and the folder.

    Raises:
        ModelError: If it is not cached and cannot be fetched.
    """
    return FuelCache().find(address) or fetch_model(address, progress)


def fetch_model(
    address: FuelAddress, progress: Progress = terminal_progress
) -> tuple[FuelAddress, Path]:
    """Download the requested version, or the newest one, unless it is in the cache.

    It is unpacked and checked beside the cache, and moved into it atomically. So it is complete or
    absent there, even if two processes fetch it at the same time. Arguments and results are those
    of `find_model`.

    Raises:
        ModelError: If it cannot be fetched.
    """
    cache = FuelCache()
    if address.version and (known := cache.find(address)):
        return known
    check_downloads(str(address))
    try:
        with open_zip(address, os.environ.get(TOKEN_VARIABLE, "")) as (response, stated):
            found = address.at(_version(address, stated))
            if known := cache.find(found):
                return known
            with cache.staging() as stage:
                save(response, stage / "model.zip", address.name, progress)
                folder = stage / "model"
                folder.mkdir()
                unpack(stage / "model.zip", folder)
                sdf_file(folder)
                return found, cache.publish(folder, found)
    except (ModelError, OSError) as error:
        raise ModelError(f"{address} was not fetched: {error}") from None


def _version(address: FuelAddress, stated: str) -> int:
    """Read the version that the server states; without one, it is the requested version."""
    if not stated:
        return address.version or 1
    if not stated.isascii() or not stated.isdigit() or not 0 < int(stated) < 10**9:
        raise ModelError(f"the server sent the version {ascii(stated)}, which is none")
    if address.version is not None and int(stated) != address.version:
        raise ModelError(f"the server sent version {stated} for version {address.version}")
    return int(stated)
