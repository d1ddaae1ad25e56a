"""Conversion of URDF with MuJoCo's parser."""

import copy
from pathlib import Path

from lxml import etree

from bt_manip.exceptions import one_line
from bt_manip.models.assets import Assets
from bt_manip.models.downloads import Progress
from bt_manip.models.errors import ModelError
from bt_manip.models.exact_xml import exact_xml
from bt_manip.models.found_model import FoundModel, MjcfModel
from bt_manip.models.hardened_xml import check_numbers, read_xml
from bt_manip.models.meshes import MESHES
from bt_manip.models.packages import find_package_file

_OPTIONS = {
    "fusestatic": "false",  # the base is a separate body with its mass
    "discardvisual": "false",
    "strippath": "false",
    "balanceinertia": "true",
}


def convert_urdf(found: FoundModel, *, convex: str, progress: Progress) -> MjcfModel:
    """Convert URDF to MJCF with MuJoCo.

    Meshes are located by ``package://``, ``file://`` or beside the file, and passed as OBJ. A
    visual whose mesh cannot be read is left out, with a warning.

    Raises:
        ModelError: If a collision mesh cannot be read, a mass or moment of inertia is impossible,
            or MuJoCo rejects the model.
    """
    import mujoco

    root = read_xml(found.path)
    if root.tag != "robot":
        raise ModelError(f"{found.path}: expected <robot>, found <{root.tag}>")
    for element in root.iter():
        check_numbers(found.path, element, urdf=True)
    assets, warnings = Assets(), []
    for mesh in list(root.iter("mesh")):
        shape = mesh.getparent().getparent()  # <visual> or <collision>
        collides = shape.tag == "collision"
        try:
            path = _mesh_path(mesh.get("filename", ""), found.path, mesh.sourceline)
            form = convex if collides else "hull"
            names = assets.colliding((path,), assets.mesh(path, "", False), path.stem, form)
        except ModelError as error:
            if collides:
                raise
            warnings.append(f"{error}; the visual is left out, the collision geometry is drawn")
            names = []
        for name in names:
            mesh.set("filename", f"{name}.obj")
            shape.addprevious(copy.deepcopy(shape))
        shape.getparent().remove(shape)
    for extension in root.findall("mujoco"):
        root.remove(extension)
    options = dict(_OPTIONS)
    if root.find("joint[@type='floating']") is not None:  # its parent is the world
        del options["fusestatic"]
    etree.SubElement(etree.SubElement(root, "mujoco"), "compiler", options)
    try:
        spec = mujoco.MjSpec.from_string(
            etree.tostring(root, encoding="unicode"), assets=assets.files
        )
        xml = exact_xml(spec)
    except (ValueError, mujoco.FatalError) as error:
        raise ModelError(f"{found.path}: MuJoCo cannot read it: {one_line(error)}") from None
    return MjcfModel(
        found.address, found.name, xml=xml, assets=assets.files, warnings=tuple(warnings)
    )


def _mesh_path(text: str, document: Path, line: int | None) -> Path:
    where = f"{document}:{line}"
    if text.startswith(("package://", "model://")):
        try:
            path = find_package_file(text, document)
        except ModelError as error:
            raise ModelError(f"{where}: {error}") from None
    else:
        path = document.parent / text.removeprefix("file://")
    if not path.is_file():
        raise ModelError(f"{where}: there is no mesh '{text}'")
    if path.suffix.lower() not in MESHES:
        raise ModelError(f"{where}: a mesh is one of {', '.join(MESHES)}, got '{text}'")
    return path.resolve()
