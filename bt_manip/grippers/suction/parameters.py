"""Parameters of a suction cup in a robot's description."""

import math
from dataclasses import dataclass
from typing import Any

import pinocchio as pin

from bt_manip.robots import GripperDescription
from bt_manip.toml_tables import TomlTable

DEFAULT_LENGTH = 0.05
"""Length of a cup with its stem that is built [m]."""

MIN_DIAMETER = 0.005
"""Diameter that every cup exceeds [m]."""


@dataclass(frozen=True)
class SuctionParameters:
    """Parameters of a suction cup; the attributes are those of `suction_gripper`."""

    diameter: float | None
    pressure: float | None
    length: float
    actuator: str | None

    @property
    def holding_force(self) -> float | None:
        """Pressure times area [N]; None if the description does not give both."""
        if self.diameter is None or self.pressure is None:
            return None
        return 0.25 * math.pi * self.diameter**2 * self.pressure


def suction_gripper(
    *,
    diameter: float | None = None,
    pressure: float | None = None,
    length: float | None = None,
    actuator: str | None = None,
    model: str | None = None,
    mount: str | None = None,
    T_mg: pin.SE3 | None = None,
) -> GripperDescription:
    """Describe a suction cup; ``[gripper]`` in a TOML file has the same keys.

    The centre of the cup's lip is the tool frame, and its axis is the tool's z axis. A model with
    an adhesion actuator has a cup: the body of the actuator. For other models a cup is built there,
    on the body that carries the tool frame; it needs `diameter` and `pressure`.

    Args:
        diameter: Diameter of the lip [m]; default: measured on the model.
        pressure: Pressure difference to the surroundings [Pa]; the holding force is this times the
            area. Default: that of the force of the model's actuator.
        length: Length of a cup that is built, with its stem [m]; default: `DEFAULT_LENGTH`.
        actuator: Name of the adhesion actuator; default: the only one.
        model: Path of its MJCF file; None if it is part of the arm's, or built.
        mount: Name of the arm's site or body to which a separate model is attached.
        T_mg: Pose of that model in the mount; default: identity.
    """
    given: dict[str, Any] = {
        "diameter": diameter,
        "pressure": pressure,
        "length": length,
        "actuator": actuator,
    }
    return GripperDescription(
        kind="suction",
        parameters={key: value for key, value in given.items() if value is not None},
        model=model,
        mount=mount,
        T_mg=pin.SE3.Identity() if T_mg is None else T_mg,
    )


def read_parameters(table: TomlTable, built: bool) -> SuctionParameters:
    """Read the parameters from a description.

    Args:
        table: The table ``[gripper]``.
        built: Whether the model has no adhesion actuator, so that a cup is built.

    Raises:
        RobotError: If a key is missing, wrong or unknown; the message names it.
    """
    needed = table.needed_number if built else table.number
    parameters = SuctionParameters(
        diameter=needed("diameter", above=MIN_DIAMETER),
        pressure=needed("pressure", above=0.0),
        length=table.number("length", DEFAULT_LENGTH, above=0.0) or DEFAULT_LENGTH,
        actuator=table.text("actuator"),
    )
    table.finish()
    if built and parameters.length < (parameters.diameter or 0.0):
        raise table.error("length", "is at least the diameter")
    return parameters
