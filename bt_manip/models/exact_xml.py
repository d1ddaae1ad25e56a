"""MJCF of a specification with full precision."""

from typing import TYPE_CHECKING, Any

import numpy as np
from lxml import etree

if TYPE_CHECKING:
    import mujoco

_JOINT = {"pos": "jnt_pos", "axis": "jnt_axis", "range": "jnt_range"}
_GEOM = {"pos": "geom_pos", "quat": "geom_quat", "size": "geom_size"}
_INERTIAL = {
    "pos": "body_ipos", "quat": "body_iquat", "mass": "body_mass", "diaginertia": "body_inertia",
}  # fmt: skip
_BODY = {"pos": "body_pos", "quat": "body_quat"}


def exact_xml(spec: "mujoco.MjSpec") -> str:
    """Compile a specification and write it as MJCF, with angles in radians.

    MuJoCo writes numbers with six digits; numbers of masses, joints and poses are replaced by the
    values of the compiled model.

    Raises:
        ValueError: If MuJoCo cannot compile it.
    """
    import mujoco

    model = spec.compile()
    root = etree.fromstring(spec.to_xml().encode())
    world = root.find("worldbody")
    bodies = list(world.iter("body"))
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, i) for i in range(1, model.nbody)]
    if [body.get("name") or "" for body in bodies] != [name or "" for name in names]:
        return etree.tostring(root, encoding="unicode")
    for i, body in enumerate([world, *bodies]):
        if i and body.getparent().tag != "frame":
            _write(body, _BODY, model, i)
        _write(body.find("inertial"), _INERTIAL, model, i)
        _each(body.findall("joint"), _JOINT, model, model.body_jntadr[i], model.body_jntnum[i])
        _each(body.findall("geom"), _GEOM, model, model.body_geomadr[i], model.body_geomnum[i])
    return etree.tostring(root, encoding="unicode")


def _each(elements: list[Any], known: dict[str, str], model: Any, first: int, count: int) -> None:
    """Write the elements of a body, unless some are in frames of their own."""
    if len(elements) != count:
        return
    for i, element in enumerate(elements):
        if element.get("type") != "mesh":  # MuJoCo changes their pose
            _write(element, known, model, int(first) + i)


def _write(element: Any, known: dict[str, str], model: Any, i: int) -> None:
    """Replace the values of existing attributes."""
    if element is None:
        return
    for attribute, field in known.items():
        text = element.get(attribute)
        if text is None:
            continue
        values = np.atleast_1d(getattr(model, field)[i])[: len(text.split())]
        # Only digits are added; attributes with another meaning are kept.
        if np.allclose(values, [float(word) for word in text.split()], rtol=1e-4, atol=1e-6):
            element.set(attribute, " ".join(repr(float(value)) for value in values))
