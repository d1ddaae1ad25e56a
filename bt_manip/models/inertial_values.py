"""Masses, densities and moments of inertia that a body can have."""

from pathlib import Path

from lxml import etree

from bt_manip.models.errors import ModelError

LARGEST = 1e10
"""Largest mass [kg], density [kg/m^3] and moment of inertia [kg m^2]."""

_KG, _MOMENT = "[kg]", "[kg m^2]"
_MJCF = {"mass": _KG, "density": "[kg/m^3]", "diaginertia": _MOMENT}
_URDF = {"mass": {"value": _KG}, "inertia": dict.fromkeys(("ixx", "iyy", "izz"), _MOMENT)}


def check_inertial_values(path: Path, element: etree._Element, *, urdf: bool = False) -> None:
    """Check the masses, densities and moments of inertia of an element of MJCF or URDF.

    Zero is accepted here: bodies that do not move may have no mass.

    Raises:
        ModelError: If one is negative, too large or not finite; with file and line.
    """
    units = _URDF.get(str(element.tag), {}) if urdf else _MJCF
    for key in units.keys() & element.attrib.keys():
        text = element.get(key, "")
        try:
            values = [float(word) for word in text.split()]
        except ValueError:
            continue  # MuJoCo reports it
        if not all(0.0 <= value <= LARGEST for value in values):
            raise ModelError(
                f"{path}:{element.sourceline}: <{element.tag}>: {key} must be at least 0 and at "
                f"most {LARGEST:g} {units[key]}, got {text}"
            )
