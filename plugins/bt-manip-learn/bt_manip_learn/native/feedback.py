"""Actuators with feedback in place of motors."""

from collections.abc import Sequence
from typing import Any

import numpy as np


def add_feedback(motors: Sequence[Any], kp: np.ndarray, kd: np.ndarray) -> list[Any]:
    """Replace motors by actuators with the force ``ctrl - kp q - kd v``, in the motor's limits.

    Args:
        motors: Motors of `ensure_motors`.
        kp: Position gain of each.  # (n,)
        kd: Velocity gain of each.  # (n,)
    """
    made = []
    for motor, position, velocity in zip(motors, kp.tolist(), kd.tolist(), strict=True):
        root, name, bounds = motor.root, motor.name, motor.forcerange
        target = {
            key: element
            for key in ("joint", "tendon")
            if (element := getattr(motor, key, None)) is not None
        }
        motor.remove()
        made.append(
            root.actuator.add(
                "general", name=name, gear=[1.0], dyntype="none", gaintype="fixed",
                gainprm=[1.0], biastype="affine", biasprm=[0.0, -position, -velocity],
                ctrllimited="false", forcelimited="true", forcerange=bounds, **target,
            )
        )  # fmt: skip
    return made
