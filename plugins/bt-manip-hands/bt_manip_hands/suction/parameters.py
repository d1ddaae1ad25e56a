"""Parameters of a suction cup in a robot's description."""

import math
from dataclasses import dataclass
from typing import Annotated, Any

import pinocchio as pin

from bt_manip.robots import GripperDescription
from bt_manip.toml import Key, TomlTable, documented, read_part


@documented
@dataclass(frozen=True)
class SuctionParameters:
    """Parameters of a suction cup, which are keys of ``[gripper]``."""

    diameter: Annotated[
        float | None,
        Key("Diameter of the lip; by default measured on the model", "m", above=0.005),
    ] = None
    pressure: Annotated[
        float | None,
        Key(
            "Pressure difference to the surroundings; the holding force is pressure times area. "
            "By default the force is that of the model's actuator",
            "Pa",
            above=0.0,
        ),
    ] = None
    length: Annotated[float, Key("Length of a built cup with its stem", "m", above=0.0)] = 0.05
    actuator: Annotated[
        str | None, Key("Name of the adhesion actuator, if the model has several")
    ] = None

    @property
    def holding_force(self) -> float | None:
        """Pressure times area [N]; None if the description does not give both."""
        if self.diameter is None or self.pressure is None:
            return None
        return 0.25 * math.pi * self.diameter**2 * self.pressure


def suction_gripper(
    *,
    model: str | None = None,
    mount: str | None = None,
    T_mg: pin.SE3 | None = None,
    **parameters: Any,
) -> GripperDescription:
    """Describe a suction cup; ``[gripper]`` in a TOML file has the same keys.

    The tool frame is at the centre of the cup's lip, and the cup's axis is the tool's z axis. In a
    model with an adhesion actuator, the actuator's body is the cup. For other models a cup is built
    on the body that carries the tool frame; this needs `diameter` and `pressure`.

    Args:
        model: Path of its MJCF file; None if it is part of the arm's file, or built.
        mount: Name of the arm's site or body to which a separate model is attached.
        T_mg: Pose of that model in the mount; default: identity.
        **parameters: The fields of `SuctionParameters`; None is the default.
    """
    return GripperDescription(
        kind="suction",
        parameters={key: value for key, value in parameters.items() if value is not None},
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
    for key in ("diameter", "pressure") if built else ():
        table.require(key, "a number")
    parameters = read_part(SuctionParameters, table)
    assert parameters is not None  # all keys have defaults
    if built and parameters.length < (parameters.diameter or 0.0):
        raise table.error("length", "is at least the diameter")
    return parameters
