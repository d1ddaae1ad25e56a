"""The objects of a scene, and their variations from cycle to cycle."""

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
"""Properties of scene objects that give their pose at the beginning of a cycle."""

_ROBOT = ("gain", "friction", "colour")
_OBSERVATION = ("noise", "delay")


@dataclass(frozen=True)
class SceneObject:
    """An object of a scene, without variation.

    Attributes:
        model: Registered name or address of the object.
        T_wo: Its pose in the world.
        parameters: Keyword arguments that it is made with.
        free: Whether it moves freely; None: as the object declares.
    """

    model: str
    T_wo: pin.SE3
    parameters: Mapping[str, Any] = field(default_factory=dict)
    free: bool | None = False


@dataclass(frozen=True)
class Randomization:
    """Variations by name and property: composer's own, or constants.

    A variation gets the nominal value, so ``noises.Multiplicative(distributions.Uniform(0.8,
    1.2))`` scales it, and ``distributions.Uniform(0.1, 0.3)`` replaces it.

    Attributes:
        objects: By name in the cell, by registered name or address, or by a pattern of names
            (``block_*``; ``*`` means those that move freely). ``mass`` [kg], ``friction``,
            ``colour``, and the ``gain`` of actuators; ``position`` [m] in the world and ``yaw``
            [rad] of scene objects; and each parameter that the object is made with, such as
            ``size`` [m].
        robots: By name in the cell: ``gain`` of the motors, one factor each, ``friction`` of the
            links, ``colour``. Links keep their masses: planners and controllers count on them.
        lights: By name in the arena (``key``, ``fill``): ``brightness``, a factor, ``colour``,
            ``position`` [m], ``direction``.
        cameras: By name (``overview``, or that of a camera in the cell): ``position`` [m],
            ``rotation`` [rad] about its own axes, ``fovy`` [degrees].
        observations: Of composer observables, by ``entity/observable``: ``noise``, which is sampled
            for each observation and added, or, by a variation that uses the value, replaces it;
            ``delay`` [steps], sampled once a cycle.
    """

    objects: Variations = field(default_factory=dict)
    robots: Variations = field(default_factory=dict)
    lights: Variations = field(default_factory=dict)
    cameras: Variations = field(default_factory=dict)
    observations: Variations = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the names of properties; objects may have parameters of any name.

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
        """Tell whether anything varies."""
        return any((self.objects, self.robots, self.lights, self.cameras, self.observations))


def unknown_property(kind: str, name: str, wanted: str, known: tuple[str, ...]) -> CellError:
    """Make the error of a property that does not exist."""
    near = did_you_mean(wanted, known)
    return CellError(f"{kind} '{name}': '{wanted}' cannot vary{near}; {', '.join(known)} can")
