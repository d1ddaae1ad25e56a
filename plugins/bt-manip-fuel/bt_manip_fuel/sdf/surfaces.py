"""Conversion of SDF surfaces to MJCF contact parameters."""

from bt_manip.models import SOLREF
from bt_manip_fuel.sdf.reader import Element, SdfReader

_KNOWN = {"friction", "contact", "bounce", "soft_contact"}
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
        reader.only(element, _KNOWN)
        mu = _friction(reader, element)
        if element.find("bounce") is not None and reader.number(
            element, "bounce/restitution_coefficient", 0.0
        ):
            reader.warn(element.find("bounce"), "<bounce> cannot be expressed")
        if element.find("soft_contact") is not None:
            reader.warn(element.find("soft_contact"), "<soft_contact> cannot be expressed")
        mask = reader.text(element, "contact/collide_bitmask")
        if mask:
            try:
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
        return _positive(reader, friction, reader.number(friction, "bullet/friction", 1.0))
    reader.only(ode, {"mu", "mu2"})
    mu = reader.number(ode, "mu", 1.0)
    mu2 = reader.number(ode, "mu2", mu)
    if mu2 != mu:
        reader.warn(ode, f"friction by direction cannot be expressed: mu {mu:g} counts, not mu2")
    return _positive(reader, ode, mu)


def _positive(reader: SdfReader, element: Element, mu: float) -> float:
    """Clip a friction coefficient: Gazebo's files use 1e6 for contacts that do not slide."""
    if mu < 0:
        raise reader.error(element, f"a friction must not be negative, got {mu:g}")
    return min(mu, 100.0)
