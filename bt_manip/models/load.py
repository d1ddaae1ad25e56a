"""Loading models by address, converted to MJCF."""

from collections.abc import Mapping

from bt_manip.models.address import FoundModel, Source, find_model
from bt_manip.models.errors import ModelError
from bt_manip.models.mjcf_model import MjcfModel
from bt_manip.models.progress import Progress, terminal_progress

CONVEX = ("hull", "parts")
"""Collision geometry of meshes: convex hull or convex parts."""


def load_model(
    address: str,
    *,
    convex: str = "hull",
    progress: Progress = terminal_progress,
    sources: Mapping[str, Source] | None = None,
) -> MjcfModel:
    """Find a model by its address, download it if needed, and convert it to MJCF.

    Args:
        address: As for `find_model`.
        convex: Collision geometry of meshes: convex ``"hull"`` or convex ``"parts"``.
        progress: Called with the progress of a download.
        sources: As for `find_model`.

    Raises:
        ModelError: When it cannot be found, fetched or converted.
    """
    if convex not in CONVEX:
        raise ModelError(f"meshes collide by their 'hull' or by 'parts', not by '{convex}'")
    return convert(find_model(address, progress, sources), convex=convex, progress=progress)


def convert(
    found: FoundModel, *, convex: str = "hull", progress: Progress = terminal_progress
) -> MjcfModel:
    """Convert a model's file to MJCF.

    Raises:
        ModelError: When it cannot be converted.
    """
    if found.format == "sdf":
        from bt_manip.models.sdf.convert import convert_sdf

        return convert_sdf(found, convex=convex, progress=progress)
    if found.format == "urdf":
        from bt_manip.models.urdf import convert_urdf

        return convert_urdf(found)
    if found.format == "mesh":
        from bt_manip.models.lone_mesh import convert_mesh

        return convert_mesh(found, convex=convex)
    return MjcfModel(found.address, found.name, path=found.path)
