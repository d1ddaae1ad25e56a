"""Parameters of a hand in a robot's description."""

from dataclasses import dataclass
from typing import Annotated

from bt_manip.toml import Key, TomlTable, documented, read_part

Names, Numbers = tuple[str, ...], tuple[float, ...]


@documented
@dataclass(frozen=True)
class HandParameters:
    """Parameters of a hand, which are keys of ``[gripper]``."""

    palm: Annotated[str, Key("Name of the body that carries the fingers")]
    thumb: Annotated[str, Key("Name of the thumb's first body")]
    fingers: Annotated[Names, Key("Names of the first bodies of the fingers that oppose the thumb")]
    joints: Annotated[Names, Key("Names of all joints of the hand")]
    open: Annotated[Numbers, Key("Joint positions of the open hand", "rad", size="joints")]
    closed: Annotated[Numbers, Key("Joint positions of the closed hand", "rad", size="joints")]
    effort: Annotated[Numbers, Key("Effort limits of the joints", "N m", above=0.0, size="joints")]
    stiffness: Annotated[
        Numbers,
        Key(
            "Torque of each joint per deviation from its reference",
            "N m/rad",
            above=0.0,
            size="joints",
        ),
    ]
    max_width: Annotated[
        float, Key("Width of the widest object between thumb and fingers", "m", above=0.0)
    ]


def read_parameters(table: TomlTable) -> HandParameters:
    """Read the parameters from a description.

    Raises:
        RobotError: If a key is missing, wrong or unknown; the message names it.
    """
    parameters = read_part(HandParameters, table)
    assert parameters is not None  # otherwise the table raises an error
    return parameters
