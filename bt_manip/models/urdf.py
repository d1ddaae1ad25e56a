"""Conversion of URDF with MuJoCo's parser."""

from pathlib import Path

from lxml import etree

from bt_manip.models.downloads import Progress
from bt_manip.models.errors import ModelError
from bt_manip.models.exact_xml import exact_xml
from bt_manip.models.found_model import FoundModel, MjcfModel
from bt_manip.models.hardened_xml import read_xml
from bt_manip.models.meshes import MESHES, read_mesh
from bt_manip.models.packages import find_package_file

_OPTIONS = {
    "fusestatic": "false",  # the base is a separate body with its mass
    "discardvisual": "false",
    "strippath": "false",
    "balanceinertia": "true",
}


def convert_urdf(found: FoundModel, *, convex: str, progress: Progress) -> MjcfModel:
    """Convert URDF to MJCF with MuJoCo.

    Meshes are located by ``package://``, ``file://`` or beside the file, and passed as OBJ. Their
    collision geometry is the hull; `convex` is ignored.

    Raises:
        ModelError: If a mesh is missing, or MuJoCo rejects the model.
    """
    import mujoco

    root = read_xml(found.path)
    if root.tag != "robot":
        raise ModelError(f"{found.path}: expected <robot>, found <{root.tag}>")
    files: dict[str, bytes] = {}
    names: dict[Path, str] = {}
    for mesh in root.iter("mesh"):
        path = _mesh_path(mesh.get("filename", ""), found.path, mesh.sourceline)
        if path not in names:
            names[path] = f"{path.stem}_{len(names)}.obj"
            files[names[path]] = read_mesh(path).to_obj()
        mesh.set("filename", names[path])
    for extension in root.findall("mujoco"):
        root.remove(extension)
    etree.SubElement(etree.SubElement(root, "mujoco"), "compiler", _OPTIONS)
    try:
        spec = mujoco.MjSpec.from_string(etree.tostring(root, encoding="unicode"), assets=files)
        xml = exact_xml(spec)
    except (ValueError, mujoco.FatalError) as error:
        first = str(error).strip().splitlines()[0]
        raise ModelError(f"{found.path}: MuJoCo cannot read it: {first}") from None
    return MjcfModel(found.address, found.name, xml=xml, assets=files)


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
