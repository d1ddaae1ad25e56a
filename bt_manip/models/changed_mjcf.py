"""MJCF with changes: other units of length, or repaired."""

from dataclasses import replace
from pathlib import Path

from bt_manip.exceptions import one_line
from bt_manip.models.errors import ModelError
from bt_manip.models.exact_xml import exact_xml, repair
from bt_manip.models.found_model import MjcfModel
from bt_manip.models.mjcf_files import check_mjcf

_PLACED = ("bodies", "frames", "geoms", "sites", "joints", "cameras", "lights")
_SIZED = ("geoms", "sites")
_DRAWN = 2  # group of geoms that viewers draw


def scaled_model(model: MjcfModel, scale: float) -> MjcfModel:
    """Return a model with all its lengths multiplied by a factor.

    Masses in the file are kept and inertias follow; masses from a density follow the volume.

    Raises:
        ModelError: If MuJoCo cannot read the model.
    """
    import mujoco

    lengths = [(kind, "pos") for kind in _PLACED] + [("bodies", "ipos"), ("hfields", "size")]
    lengths += [(kind, size) for kind in _SIZED for size in ("size", "fromto")]
    lengths += [("meshes", "scale"), ("meshes", "refpos")]
    try:
        if model.xml:
            spec = mujoco.MjSpec.from_string(model.xml, assets=dict(model.assets))
        else:
            spec = mujoco.MjSpec.from_file(str(model.path))
        if model.path is not None:
            spec.modelfiledir = str(model.path.parent)
        for kind, attribute in lengths:
            for element in getattr(spec, kind):
                setattr(element, attribute, getattr(element, attribute) * scale)
        for body in spec.bodies:
            body.inertia, body.fullinertia = body.inertia * scale**2, body.fullinertia * scale**2
        for joint in spec.joints:
            if joint.type == mujoco.mjtJoint.mjJNT_SLIDE:
                joint.range, joint.ref = joint.range * scale, joint.ref * scale
        xml = exact_xml(spec, check_mjcf(model.path) if model.path else ())
    except ValueError as error:
        raise ModelError(f"{model.address}: cannot be scaled: {one_line(error)}") from None
    return replace(model, xml=xml)


def repaired_mjcf(path: Path) -> tuple[str, tuple[str, ...]]:
    """Return MJCF without the visuals whose mesh files are missing, and a warning for each.

    Collision geoms of their bodies are drawn instead. Refused inertias are corrected. Both are
    empty if nothing changes, and for errors reported later, such as a missing mesh that collides.
    """
    import mujoco

    files = check_mjcf(path)
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        folder, attached = path.parent / (spec.meshdir or ""), [file.name for file in files]
        lost = {
            mesh.name: mesh
            for mesh in spec.meshes
            if mesh.file and not (folder / mesh.file).exists()
            and Path(mesh.file).name not in attached
        }  # fmt: skip
        geoms = [geom for geom in spec.geoms if geom.meshname in lost]
        if not (geoms or repair(spec)) or any(geom.contype or geom.conaffinity for geom in geoms):
            return "", ()
        names = sorted({lost[geom.meshname].file for geom in geoms})
        for other in [other for geom in geoms for other in geom.parent.geoms]:
            other.group = _DRAWN if other.contype or other.conaffinity else other.group
        for element in (*geoms, *lost.values()):
            spec.delete(element)
        xml = exact_xml(spec, files)
    except ValueError:
        return "", ()
    rest = "the visual is left out, the collision geometry is drawn"
    return xml, tuple(f"{path}: there is no mesh '{name}'; {rest}" for name in names)
