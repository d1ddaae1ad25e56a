"""Loading models by address, converted to MJCF."""

from collections.abc import Mapping

from bt_manip.exceptions import did_you_mean
from bt_manip.installed import installed_parts
from bt_manip.models.address import Source, find_model
from bt_manip.models.downloads import Progress, terminal_progress
from bt_manip.models.errors import ModelError
from bt_manip.models.formats import ModelFormat, built_in_formats
from bt_manip.models.found_model import MjcfModel

CONVEX = ("hull", "parts")
"""Collision geometry of meshes: convex hull or convex parts."""


def load_model(
    address: str,
    *,
    convex: str = "hull",
    progress: Progress = terminal_progress,
    sources: Mapping[str, Source] | None = None,
    formats: Mapping[str, ModelFormat] | None = None,
) -> MjcfModel:
    """Find a model by its address, download it if needed, and convert it to MJCF.

    Args:
        address: As for `find_model`.
        convex: Collision geometry of meshes: convex ``"hull"`` or convex ``"parts"``.
        progress: Called with the progress of a download.
        sources: As for `find_model`.
        formats: As for `find_model`.

    Raises:
        ModelError: When it cannot be found, fetched or converted.
    """
    if convex not in CONVEX:
        raise ModelError(f"meshes collide by their 'hull' or by 'parts', not by '{convex}'")
    found = find_model(address, progress, sources, formats)
    known = built_in_formats() if formats is None else formats
    if found.format not in known and formats is None:
        known = installed_parts().model_formats.copies()
    if found.format not in known:
        near = did_you_mean(found.format, known)
        raise ModelError(f"'{address}': unknown format '{found.format}'{near}")
    return known[found.format].convert(found, convex=convex, progress=progress)
