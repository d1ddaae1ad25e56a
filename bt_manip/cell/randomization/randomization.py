"""What varies from episode to episode, and by what."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from bt_manip.exceptions import did_you_mean

from ..exceptions import CellError
from ..physics.model_properties import CAMERA, LIGHT, PROPERTIES
from .sampling import Varied

Lines = Mapping[str, Mapping[str, Varied]]
"""Variations by thing and quantity."""

PHYSICAL = ("mass", "friction", "colour", "gain")
"""Quantities of objects that are set on the compiled model."""

POSE = ("position", "yaw")
"""Quantities of objects of the scene that say where they stand when an episode begins."""

_ROBOT = ("gain", "friction", "colour")
_OBSERVATION = ("noise", "delay")


@dataclass(frozen=True)
class Randomization:
    """Variations by thing and quantity: composer's own, or values that are always the same.

    A variation gets the nominal value, so ``noises.Multiplicative(distributions.Uniform(0.8,
    1.2))`` scales what the model says, and ``distributions.Uniform(0.1, 0.3)`` does without it.

    Attributes:
        objects: By name in the cell, by registered name or address, or by a pattern of names
            (``block_*``). ``mass`` [kg], ``friction``, ``colour``, and the ``gain`` of actuators;
            ``position`` [m] in the world and ``yaw`` [rad], of what stands in the scene; and each
            parameter that the object is made with, such as ``size`` [m].
        robots: By name in the cell: ``gain`` of the motors, one factor each, ``friction``,
            ``colour``. Links keep their masses: planners and controllers count on them.
        lights: By name in the arena (``key``, ``fill``): ``brightness``, a factor, ``colour``,
            ``position`` [m], ``direction``.
        cameras: By name (``overview``, or that of a camera in the cell): ``position`` [m],
            ``rotation`` [rad] about its own axes, ``fovy`` [degrees].
        observations: Of composer observables, by ``entity/observable``: ``noise``, which is drawn
            for each observation and added, or, by a variation that wants the value, replaces it;
            ``delay`` [steps], drawn once an episode.
    """

    objects: Lines = field(default_factory=dict)
    robots: Lines = field(default_factory=dict)
    lights: Lines = field(default_factory=dict)
    cameras: Lines = field(default_factory=dict)
    observations: Lines = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse quantities that do not exist; objects may have parameters of any name.

        Raises:
            CellError: When there is one; the nearest names are offered.
        """
        for where, lines, known in (
            ("robots", self.robots, _ROBOT),
            ("lights", self.lights, tuple(PROPERTIES[LIGHT])),
            ("cameras", self.cameras, tuple(PROPERTIES[CAMERA])),
            ("observations", self.observations, _OBSERVATION),
        ):
            for thing, varied in lines.items():
                for name in varied:
                    if name not in known:
                        raise unknown_quantity(where, thing, name, known)

    def __bool__(self) -> bool:
        """Tell whether anything varies."""
        return any((self.objects, self.robots, self.lights, self.cameras, self.observations))


def unknown_quantity(where: str, thing: str, name: str, known: tuple[str, ...]) -> CellError:
    """Make the error of something that shall vary and that a thing does not have."""
    return CellError(
        f"{where} '{thing}': '{name}' cannot vary{did_you_mean(name, known)}; "
        f"{', '.join(known)} can"
    )
