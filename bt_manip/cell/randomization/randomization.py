"""Declaration of a randomization."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import pinocchio as pin

from bt_manip.exceptions import did_you_mean

from ..exceptions import CellError
from ..physics.model_properties import CAMERA, LIGHT, PROPERTIES
from .variations import Varied

Variations = Mapping[str, Mapping[str, Varied]]
"""Variations by name and property."""

PHYSICAL = ("mass", "friction", "colour", "gain")
"""Properties of objects that are overridden in the compiled model."""

POSE = ("position", "yaw")
"""Properties of a scene's objects: their pose at the start of a cycle."""

_ROBOT = ("gain", "friction", "colour")
_OBSERVATION = ("noise", "delay")


@dataclass(frozen=True)
class InitialObject:
    """An object of a scene in its nominal state.

    Attributes:
        model: Registered name or address of the object.
        T_wo: Its pose in the world.
        parameters: Its keyword arguments.
        free: Whether it moves freely; None: as its class declares.
    """

    model: str
    T_wo: pin.SE3
    parameters: Mapping[str, Any] = field(default_factory=dict)
    free: bool | None = False


@dataclass(frozen=True)
class Randomization:
    """Variations by name and property: composer's own, or constants.

    A variation is given the nominal value: ``noises.Multiplicative(distributions.Uniform(0.8,
    1.2))`` scales it, ``distributions.Uniform(0.1, 0.3)`` replaces it.

    Attributes:
        objects: By name in the cell, registered name, address, or a pattern of names (``block_*``;
            ``*``: all freely moving objects). ``mass`` [kg], ``friction``, ``colour``, and the
            ``gain`` of actuators; ``position`` [m] in the world and ``yaw`` [rad] of the scene's
            objects; and each parameter of the object, such as ``size`` [m].
        robots: By name in the cell: ``gain`` of the motors (a factor for each), ``friction`` of the
            links, ``colour``. Masses of links are not varied: planners and controllers use them.
        lights: By name in the arena (``key``, ``fill``): ``brightness``, a factor, ``colour``,
            ``position`` [m], ``direction``.
        cameras: By name (``overview``, or a camera in the cell): ``position`` [m], ``rotation``
            [rad] about its own axes, ``fovy`` [degrees].
        observations: Of composer observables, by ``entity/observable``: ``noise``, sampled for each
            observation and added to it, or replacing it if the variation uses the value; ``delay``
            [steps], sampled once per cycle.
    """

    objects: Variations = field(default_factory=dict)
    robots: Variations = field(default_factory=dict)
    lights: Variations = field(default_factory=dict)
    cameras: Variations = field(default_factory=dict)
    observations: Variations = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the names of properties, except of objects, whose parameters may have any name.

        Raises:
            CellError: If there is no such property; the nearest names are offered.
        """
        for kind, variations, known in (
            ("robots", self.robots, _ROBOT),
            ("lights", self.lights, tuple(PROPERTIES[LIGHT])),
            ("cameras", self.cameras, tuple(PROPERTIES[CAMERA])),
            ("observations", self.observations, _OBSERVATION),
        ):
            for name, varied in variations.items():
                for wanted in varied:
                    if wanted not in known:
                        raise unknown_property(kind, name, wanted, known)

    def __bool__(self) -> bool:
        """Return whether there are any variations."""
        return any((self.objects, self.robots, self.lights, self.cameras, self.observations))


def unknown_property(kind: str, name: str, wanted: str, known: tuple[str, ...]) -> CellError:
    """Return the error for a property that does not exist."""
    near = did_you_mean(wanted, known)
    return CellError(f"{kind} '{name}': '{wanted}' cannot vary{near}; {', '.join(known)} can")
