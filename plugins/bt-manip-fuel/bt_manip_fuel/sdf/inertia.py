"""Mass and inertia of a link, with SDF's defaults."""

import numpy as np
from lxml import etree

from bt_manip_fuel.sdf.reader import Element, SdfReader, is_true
from bt_manip_fuel.sdf.scopes import Scopes

_ROUNDING = 1e-6  # relative to the trace
_LARGEST = 1e10  # [kg], [kg m^2]


def inertial(
    reader: SdfReader, scopes: Scopes, name: str, link: Element, static: bool
) -> dict[str, object] | None:
    """Return a link's inertial for MJCF, or None to derive it from the shapes.

    Defaults are 1: the mass [kg], and the inertia about each axis [kg m^2].

    Raises:
        ModelError: If the mass or the inertia is impossible.
    """
    source = element = link.find("inertial")
    if element is None:
        source, element = link, etree.Element("inertial")
    if is_true(element.get("auto")):
        return None
    reader.only(element, {"pose", "mass", "inertia", "density"})
    mass, inertia = reader.number(element, "mass", 1.0), _inertia(reader, element)
    if not static and element.find("mass") is None:
        reader.warn(source, f"link '{name}': the file gives no mass; SDF's default is 1 kg")
    problem = _problem(mass, inertia)
    if problem and static:
        reader.warn(source, f"{problem}; it does not move, so its inertia follows from the shapes")
        return None
    if problem:
        raise reader.error(source, f"link '{name}': {problem}")
    T = scopes.local(name, element.find("pose"))
    inertia = T.rotation @ _balanced(reader, source, name, inertia) @ T.rotation.T
    full = [*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    return {"pos": T.translation, "mass": mass, "fullinertia": full}


def _inertia(reader: SdfReader, element: Element) -> np.ndarray:
    """Read the tensor about the centre of mass."""  # (3, 3) [kg m^2]
    values = [
        reader.number(element, f"inertia/{tag}", 1.0 if tag[1] == tag[2] else 0.0)
        for tag in ("ixx", "ixy", "ixz", "ixy", "iyy", "iyz", "ixz", "iyz", "izz")
    ]
    return np.array(values).reshape(3, 3)


def _problem(mass: float, inertia: np.ndarray) -> str:
    if not 0 < mass <= _LARGEST:
        return f"a mass must be a positive number of at most {_LARGEST:g} [kg], got {mass:g}"
    if not np.abs(inertia).max() <= _LARGEST or np.linalg.eigvalsh(inertia)[0] <= 0:
        return f"an inertia must be positive about every axis, at most {_LARGEST:g} [kg m^2]"
    return ""


def _balanced(reader: SdfReader, element: Element, name: str, inertia: np.ndarray) -> np.ndarray:
    """Check that no principal moment exceeds the sum of the other two.

    MuJoCo rejects such a body. Small differences are rounding errors of flat objects; larger ones
    are guesses by the file's author, and are replaced by a ball's inertia with the same trace.
    """
    moments = np.linalg.eigvalsh(inertia)
    trace = float(moments.sum())
    excess = float(2 * moments[2] - trace)
    if excess > _ROUNDING * trace:
        reader.warn(
            element,
            f"link '{name}': invalid principal inertias "
            f"{', '.join(f'{m:.3g}' for m in moments)}; all of them become {trace / 3:.3g} kg m^2",
        )
        return np.eye(3) * trace / 3
    if excess > -1e-12 * trace:
        return inertia + np.eye(3) * (max(excess, 0.0) + 1e-12 * trace)
    return inertia
