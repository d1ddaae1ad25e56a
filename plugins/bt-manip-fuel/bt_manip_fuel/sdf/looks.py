"""Materials of SDF as materials of MJCF."""

import numpy as np

from bt_manip.models import Assets, ModelError, read_png
from bt_manip_fuel.sdf.reader import Element, SdfReader
from bt_manip_fuel.sdf.shapes import SdfShape
from bt_manip_fuel.sdf.uris import FetchFuel, find_file

_KNOWN = {
    "ambient", "diffuse", "specular", "emissive", "lighting", "double_sided", "shininess",
    "render_order", "pbr",
}  # fmt: skip
_GREY = (0.7, 0.7, 0.7, 1.0)


def material_of(
    reader: SdfReader, assets: Assets, visual: Element, shape: SdfShape, fetch: FetchFuel
) -> str:
    """Return the material of a visual.

    Args:
        reader: Reads values.
        assets: The assets to which the material is added.
        visual: The visual.
        shape: Its shape; a mesh may have its own colour or image.
        fetch: Returns models of Fuel.

    Raises:
        ModelError: If a colour is invalid.
    """
    white = None if shape.image is None else (1.0, 1.0, 1.0, 1.0)
    own = np.array(white or shape.rgba or _GREY)
    material = visual.find("material")
    if material is None:
        return assets.material(_visible(reader, visual, own), 0.1, 0.0, shape.image)
    reader.only(material, _KNOWN)
    image = _albedo(reader, material, shape, fetch)
    diffuse = _colour(reader, material, "diffuse")
    if diffuse is None:
        diffuse = _colour(reader, material, "ambient")
    if diffuse is None:
        image = image or shape.image
        diffuse = own if image is None else np.ones(4)
    specular, emissive = (_colour(reader, material, tag) for tag in ("specular", "emissive"))
    return assets.material(
        _visible(reader, visual, diffuse),
        0.0 if specular is None else float(specular[:3].mean()),
        0.0 if emissive is None else float(emissive[:3].mean()),
        image,
    )


def _albedo(
    reader: SdfReader, material: Element, shape: SdfShape, fetch: FetchFuel
) -> bytes | None:
    """Return the image of a physically based material."""
    pbr = material.find("pbr")
    if pbr is None:
        return None
    element = pbr.find("*/albedo_map")
    image = None
    if element is not None and shape.unfolded:
        try:
            found = find_file((element.text or "").strip(), reader.document(material), fetch)
        except ModelError as error:
            raise reader.error(element, str(error)) from None
        image = read_png(found.path)
    if image is None:
        reader.warn(pbr, "<pbr> of <material>: only a PNG as albedo_map of a mesh with texture "
                         "coordinates can be expressed")  # fmt: skip
    return image


def _colour(reader: SdfReader, material: Element, tag: str) -> np.ndarray | None:
    """Return a colour of three or four numbers, or None."""  # (4,)
    element = material.find(tag)
    if element is None:
        return None
    count = 3 if len((element.text or "").split()) == 3 else 4
    return np.clip([*reader.numbers(element, count), 1.0][:4], 0.0, 1.0)


def _visible(reader: SdfReader, visual: Element, rgba: np.ndarray) -> np.ndarray:
    opacity = 1.0 - reader.number(visual, "transparency", 0.0)
    return np.array([*rgba[:3], float(np.clip(rgba[3] * opacity, 0.0, 1.0))])
