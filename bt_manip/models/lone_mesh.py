"""Conversion of a mesh file to a model with one body."""

import numpy as np
from lxml import etree

from bt_manip.models.assets import SOLREF, Assets
from bt_manip.models.downloads import Progress
from bt_manip.models.errors import ModelError
from bt_manip.models.found_model import FoundModel, MjcfModel
from bt_manip.models.images import image_of_obj, read_png
from bt_manip.models.meshes import read_mesh

_WEIGHTLESS = {"mass": "0"}


def convert_mesh(found: FoundModel, *, convex: str, progress: Progress) -> MjcfModel:
    """Convert a mesh to a body; its mass follows from the enclosed volume, at MuJoCo's 1000 kg/m3.

    Raises:
        ModelError: If it cannot be read, or encloses no volume.
    """
    mesh = read_mesh(found.path)
    if not mesh.watertight:
        raise ModelError(
            f"{found.path}: the mesh is not watertight, so it has no volume and no mass; "
            "close its holes, or give it mass and shape in an SDF or MJCF file"
        )
    assets = Assets()
    seen = assets.seen((), mesh, found.name)
    weighs = not mesh.convex_parts  # else its parts do, as their surfaces need not be closed
    for element in assets.element.iter("mesh"):
        element.set("inertia", "exact" if weighs else "shell")
    parts = assets.colliding((), mesh, found.name, convex)
    place = image_of_obj(found.path, found.root) if mesh.uv is not None else None
    image = None if place is None else read_png(place)
    grey = (0.7, 0.7, 0.7, 1.0) if image is None else (1.0, 1.0, 1.0, 1.0)
    material = assets.material(np.array(mesh.colour or grey), 0.1, 0.0, image)
    root = etree.Element("mujoco", model=found.name)
    etree.SubElement(root, "compiler", angle="radian", autolimits="true")
    root.append(assets.element)
    body = etree.SubElement(etree.SubElement(root, "worldbody"), "body", name=found.name)
    etree.SubElement(
        body, "geom", type="mesh", mesh=seen, group="2", contype="0", conaffinity="0",
        material=material, **({} if weighs else _WEIGHTLESS),
    )  # fmt: skip
    for i, part in enumerate(parts):
        etree.SubElement(
            body, "geom", name=f"collision{i}", type="mesh", mesh=part, group="3",
            solref=SOLREF, rgba="0.3 0.5 0.8 0.4", **(_WEIGHTLESS if weighs else {}),
        )  # fmt: skip
    xml = etree.tostring(root, encoding="unicode")
    return MjcfModel(found.address, found.name, xml=xml, assets=assets.files)
