"""MJCF of a specification with full precision."""

import warnings
from collections.abc import Iterable
from pathlib import Path
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
_OF_WORLD = {
    "boundmass", "boundinertia", "settotalmass", "inertiafromgeom", "inertiagrouprange",
}  # fmt: skip
"""Settings of the compiler that change the masses of all models of a world."""
_PLACED = ("frame", "body", "geom", "site", "camera", "joint", "light")
_TRIANGLE = 1.0 + 1e-9  # largest ratio of a principal moment to the sum of the others
_LEAST_MOMENT = 1e-14  # in place of one that is not positive [kg m^2]; MuJoCo takes 1e-15
_VECTORS = {"joint": ("axis", "0 0 1"), "light": ("dir", "0 0 -1")}
"""Elements with a direction in place of an orientation, with its attribute and default."""


def exact_xml(spec: "mujoco.MjSpec", files: Iterable[Path] = ()) -> str:
    """Compile a specification and write it as MJCF, with angles in radians.

    MuJoCo writes numbers with six digits; numbers of masses, joints and poses are replaced by the
    values of the compiled model. Frames are composed into their children, as PyMJCF knows none.

    Args:
        spec: The specification.
        files: Its meshes and images, if it attaches models: MuJoCo writes theirs without folders.

    Raises:
        ValueError: If MuJoCo cannot compile it, or two attached models have different files of a
            name.
    """
    import mujoco

    repair(spec)
    with warnings.catch_warnings(action="ignore"):  # options of attached models, dropped later
        model = spec.compile()
        root = etree.fromstring(spec.to_xml().encode())
        if _OF_WORLD & {*root.find("compiler").attrib}:
            spec.compiler.saveinertial = True
            root = etree.fromstring(spec.to_xml().encode())
    for key in (*_OF_WORLD, "saveinertial"):
        root.find("compiler").attrib.pop(key, None)
    for element in root.find("asset") if files else ():
        _find_files(element, files)
    world = root.find("worldbody")
    while (frame := world.find(".//frame")) is not None:  # outer ones first
        _resolve(frame)
    bodies = list(world.iter("body"))
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, i) for i in range(1, model.nbody)]
    if [body.get("name") or "" for body in bodies] != [name or "" for name in names]:
        return etree.tostring(root, encoding="unicode")
    for i, body in enumerate([world, *bodies]):
        if i:
            _write(body, _BODY, model, i)
        _write(body.find("inertial"), _INERTIAL, model, i)
        _each(body.findall("joint"), _JOINT, model, model.body_jntadr[i], model.body_jntnum[i])
        _each(body.findall("geom"), _GEOM, model, model.body_geomadr[i], model.body_geomnum[i])
    return etree.tostring(root, encoding="unicode")


def repair(spec: "mujoco.MjSpec") -> bool:
    """Turn inertias that MuJoCo refuses into ones as impossible; return whether there were any."""
    changed = False
    for body in spec.bodies:
        full = np.array(body.fullinertia)[
            [[0, 3, 4], [3, 1, 5], [4, 5, 2]]
        ]  # xx, yy, zz, xy, xz, yz
        moments = body.inertia if np.isnan(full[0, 0]) else np.linalg.eigvalsh(full)
        impossible = moments.min() <= 0 or moments.max() > _TRIANGLE * np.sort(moments)[:2].sum()
        if body.explicitinertial and body.mass > 0 and len(body.geoms) and impossible:
            most = max(abs(moments).max(), _LEAST_MOMENT)
            body.fullinertia, body.inertia = np.full(6, np.nan), [most, most, _LEAST_MOMENT]
            changed = True
    return changed


def _find_files(asset: Any, files: Iterable[Path]) -> None:
    """Replace the files of an asset by their full paths."""
    for key, value in asset.attrib.items():
        if key.startswith("file"):
            named = [file for file in files if file.match(str(Path(value)))]
            if len({file.read_bytes() for file in named}) > 1:
                raise ValueError(f"several files '{value}' of attached models")
            asset.set(key, str(named[0].resolve()) if named else value)


def _resolve(frame: Any) -> None:
    """Replace a frame by its children, with its pose and default class."""
    import mujoco

    for child in frame:
        if child.tag in _PLACED:
            at, turn = _numbers(frame, "pos", "0 0 0"), _numbers(frame, "quat", "1 0 0 0")
            result = np.zeros(3), np.zeros(4)
            mujoco.mju_rotVecQuat(result[0], _numbers(child, "pos", "0 0 0"), turn)
            child.set("pos", _text(at + result[0]))
            if (vector := _VECTORS.get(child.tag)) is not None:
                mujoco.mju_rotVecQuat(result[0], _numbers(child, *vector), turn)
                child.set(vector[0], _text(result[0]))
            else:
                mujoco.mju_mulQuat(result[1], turn, _numbers(child, "quat", "1 0 0 0"))
                child.set("quat", _text(result[1]))
        key = "childclass" if child.tag in ("body", "frame") else "class"
        if frame.get("childclass") and child.get(key) is None and child.tag in _PLACED:
            child.set(key, frame.get("childclass"))
        frame.addprevious(child)
    frame.getparent().remove(frame)


def _numbers(element: Any, attribute: str, default: str) -> np.ndarray:
    return np.array([float(word) for word in element.get(attribute, default).split()])


def _text(values: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in values)


def _each(elements: list[Any], known: dict[str, str], model: Any, first: int, count: int) -> None:
    """Write the elements of a body."""
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
            element.set(attribute, _text(values))
