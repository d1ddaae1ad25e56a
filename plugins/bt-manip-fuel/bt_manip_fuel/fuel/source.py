"""Fuel as a source of models for bt-manip, and its cache."""

from collections.abc import Iterator
from pathlib import Path

from bt_manip.models import FoundModel, ModelCache, Progress, model_name
from bt_manip_fuel.fuel.address import fuel_address
from bt_manip_fuel.fuel.cache import FuelCache
from bt_manip_fuel.model_config import sdf_file

FUEL_KINDS = ("fuel", "http", "https")
"""Kinds of addresses of models on Fuel."""


def find_fuel(address: str, progress: Progress) -> FoundModel:
    """Return a model of Fuel, from the cache, or else downloaded.

    Raises:
        ModelError: If it is not cached and cannot be fetched.
    """
    from bt_manip_fuel.fuel.client import find_model

    found, folder = find_model(fuel_address(address), progress)
    return FoundModel(str(found), model_name(found.name), sdf_file(folder), "sdf", folder)


find_fuel.checks_downloads = True  # type: ignore[attr-defined]


class FuelModels(ModelCache):
    """Gazebo's cache of models of Fuel."""

    kinds = FUEL_KINDS

    def addresses(self, everything: bool) -> Iterator[str]:
        """Yield the addresses of all cached models; others are too many to list."""
        return map(str, FuelCache().models())

    def fetch(self, address: str) -> tuple[str, Path]:
        """Download a model, or a newer version of it."""
        from bt_manip_fuel.fuel.client import fetch_model

        found, folder = fetch_model(fuel_address(address))
        return str(found), folder

    def remove(self, address: str) -> list[Path]:
        """Delete a version or all versions of a model."""
        return FuelCache().remove(fuel_address(address))
