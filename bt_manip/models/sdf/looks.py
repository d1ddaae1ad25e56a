"""Materials of SDF as materials of MJCF."""

import numpy as np

from bt_manip.models.sdf.assets import Assets
from bt_manip.models.sdf.reader import Element, SdfReader

_KNOWN = {
    "ambient", "diffuse", "specular", "emissive", "lighting", "double_sided", "shininess",
    "render_order",
}  # fmt: skip
_GREY = (0.7, 0.7, 0.7, 1.0)


def material_of(
    reader: SdfReader, assets: Assets, visual: Element, own: tuple[float, ...] | None
) -> str:
    """Give the material of a visual.

    Args:
        reader: Reads values.
        assets: Takes the material.
        visual: The visual.
        own: The colour that its mesh has by itself.

    Raises:
        ModelError: When a colour is none.
    """
    material = visual.find("material")
    if material is None:
        return assets.material(_visible(reader, visual, np.array(own or _GREY)), 0.1, 0.0)
    reader.only(material, _KNOWN)
    diffuse = colour(reader, material, "diffuse")
    if diffuse is None:
        diffuse = colour(reader, material, "ambient")
    rgba = np.array(own or _GREY) if diffuse is None else diffuse
    specular, emissive = (colour(reader, material, tag) for tag in ("specular", "emissive"))
    return assets.material(
        _visible(reader, visual, rgba),
        0.0 if specular is None else float(specular[:3].mean()),
        0.0 if emissive is None else float(emissive[:3].mean()),
    )


def colour(reader: SdfReader, material: Element, tag: str) -> np.ndarray | None:
    """Read a colour of three or four numbers; None where there is none.

    Raises:
        ModelError: When it is none.
    """  # (4,)
    element = material.find(tag)
    if element is None:
        return None
    count = 3 if len((element.text or "").split()) == 3 else 4
    return np.clip([*reader.numbers(element, count), 1.0][:4], 0.0, 1.0)


def _visible(reader: SdfReader, visual: Element, rgba: np.ndarray) -> np.ndarray:
    opacity = 1.0 - reader.number(visual, "transparency", 0.0)
    return np.array([*rgba[:3], float(np.clip(rgba[3] * opacity, 0.0, 1.0))])
