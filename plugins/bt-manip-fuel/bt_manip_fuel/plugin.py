"""Hooks of this package."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from bt_manip import hookimpl


@hookimpl
def register_model_sources(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the models of Fuel: ``fuel:OWNER/NAME``, and URLs of models."""
    from bt_manip_fuel.fuel.source import FUEL_KINDS, find_fuel

    for kind in FUEL_KINDS:
        register(kind, find_fuel)


@hookimpl
def register_model_formats(register: Callable[[str, Any], None]) -> None:
    """Register SDFormat: files, and folders with a ``model.config``."""
    from bt_manip.models import ModelFormat

    register("sdf", ModelFormat(_convert, (".sdf", ".world"), "sdf", _find_in))


@hookimpl
def register_model_caches(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register Gazebo's cache of models of Fuel."""
    from bt_manip_fuel.fuel.source import FuelModels

    register("fuel", FuelModels)


def _convert(found: Any, *, convex: str, progress: Any) -> Any:
    from bt_manip_fuel.sdf.convert import convert_sdf

    return convert_sdf(found, convex=convex, progress=progress)


def _find_in(folder: Path) -> Path | None:
    from bt_manip_fuel.model_config import MODEL_CONFIG, sdf_file

    return sdf_file(folder) if (folder / MODEL_CONFIG).is_file() else None
