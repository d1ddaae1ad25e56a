"""Parameters of a hand in a robot's description."""

from dataclasses import dataclass

import numpy as np

from bt_manip.toml_tables import TomlTable


@dataclass(frozen=True, eq=False)
class HandParameters:
    """Parameters of a hand, which are the keys of ``[gripper]``.

    Attributes:
        palm: Name of the body that carries the fingers.
        thumb: Name of the thumb's first body.
        fingers: Names of the first bodies of the fingers that oppose the thumb.
        joints: Names of all joints of the hand.
        open: Joint positions of the open hand [rad].  # (n,)
        closed: Joint positions of the closed hand [rad].  # (n,)
        effort: Effort limit of each joint [N m].  # (n,)
        stiffness: Torque of each joint per deviation from its reference [N m/rad].  # (n,)
        max_width: Width of the widest object between thumb and fingers [m].
    """

    palm: str
    thumb: str
    fingers: tuple[str, ...]
    joints: tuple[str, ...]
    open: np.ndarray
    closed: np.ndarray
    effort: np.ndarray
    stiffness: np.ndarray
    max_width: float


def read_parameters(table: TomlTable) -> HandParameters:
    """Read the parameters from a description.

    Raises:
        RobotError: If a key is missing, wrong or unknown; the message names it.
    """
    joints = table.texts("joints")
    n = len(joints)
    postures = [table.needed_numbers(key, n) for key in ("open", "closed")]
    drives = [table.needed_numbers(key, n, above=0.0) for key in ("effort", "stiffness")]
    parameters = HandParameters(
        table.needed_text("palm"),
        table.needed_text("thumb"),
        table.texts("fingers"),
        joints,
        *(np.array(values) for values in (*postures, *drives)),
        max_width=table.needed_number("max_width", above=0.0),
    )
    table.finish()
    return parameters
