"""Conversion of SDF surfaces to MJCF contact parameters."""

from bt_manip.models import SOLREF
from bt_manip_fuel.sdf.reader import Element, SdfReader

_ROLLING = (0.005, 0.0001)  # [m] MuJoCo's default torsional and rolling friction


def surface(reader: SdfReader, collision: Element) -> dict[str, object]:
    """Return friction and softness of a collision; the default friction is 1.

    Raises:
        ModelError: If a number is invalid.
    """
    attributes: dict[str, object] = {"solref": SOLREF}
    element = collision.find("surface")
    mu = 1.0
    if element is not None:
        reader.only(element, {"friction", "contact", "bounce"})
        mu = _friction(reader, element)
        if reader.number(element, "bounce/restitution_coefficient", 0.0):
            reader.warn(element.find("bounce"), "<bounce> cannot be expressed")
        mask = reader.text(element, "contact/collide_bitmask")
        try:
            if mask:
                attributes["contype"] = attributes["conaffinity"] = int(mask, 0) & 0x7FFFFFFF
        except ValueError:
            raise reader.error(element, f"collide_bitmask: no number: '{mask}'") from None
    attributes["friction"] = (mu, *_ROLLING)
    return attributes


def _friction(reader: SdfReader, element: Element) -> float:
    friction = element.find("friction")
    if friction is None:
        return 1.0
    reader.only(friction, {"ode", "bullet"})
    ode = friction.find("ode")
    if ode is None:
        mu = reader.number(friction, "bullet/friction", 1.0)
    else:
        reader.only(ode, {"mu", "mu2"})
        mu = reader.number(ode, "mu", 1.0)
        if reader.number(ode, "mu2", mu) != mu:
            reader.warn(
                ode, f"friction by direction cannot be expressed: mu {mu:g} counts, not mu2"
            )
    if mu < 0:
        raise reader.error(friction, f"a friction must not be negative, got {mu:g}")
    return min(mu, 100.0)  # Gazebo's files have 1e6 for contacts that do not slide
