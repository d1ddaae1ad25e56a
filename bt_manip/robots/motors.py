"""Replacement of a model's actuators by motors."""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from dm_control import mjcf

from .joint_limits import is_motor


def ensure_motors(
    root: mjcf.RootElement,
    alone: mujoco.MjModel,
    driven: Sequence[Any],
    efforts: Sequence[float],
    *,
    freed: Sequence[Any] = (),
) -> list[Any]:
    """Ensure that each joint or tendon has exactly one motor and no other actuator.

    Args:
        root: The robot's model.
        alone: The same model, compiled on its own.
        driven: The joints and tendons that get a motor.
        efforts: Maximum effort of each motor.
        freed: Further joints whose actuators are removed.
    """
    kept: dict[str, Any] = {}
    names = {element.full_identifier for element in driven}
    moved = {element.full_identifier for element in (*driven, *freed)}
    for actuator in list(root.find_all("actuator")):
        target = getattr(actuator, "joint", None) or getattr(actuator, "tendon", None)
        if target is None:
            continue
        name = target.full_identifier
        if name in moved:
            i = _index(alone, actuator)
            plain = i is not None and is_motor(alone, i) and alone.actuator_gear[i, 0] == 1.0
            if plain and name not in kept and name in names:
                kept[name] = actuator
                continue
        elif target.tag == "joint" or not _pulls_only(target, moved):
            continue
        actuator.remove()
    return [
        _motor(root, element, float(effort), kept.get(element.full_identifier))
        for element, effort in zip(driven, efforts, strict=True)
    ]


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
                "general", name=name, gear=[1.0, 0, 0, 0, 0, 0], dyntype="none", gaintype="fixed",
                gainprm=[1.0], biastype="affine", biasprm=[0.0, -position, -velocity],
                ctrllimited="false", forcelimited="true", forcerange=bounds, **target,
            )
        )  # fmt: skip
    return made


def _motor(root: mjcf.RootElement, element: Any, effort: float, motor: Any) -> Any:
    if motor is None:
        what = "tendon" if element.tag in ("fixed", "spatial") else "joint"
        motor = element.root.actuator.add(
            "motor", name=f"{element.name}_motor", gear=[1.0, 0, 0, 0, 0, 0], **{what: element}
        )
    motor.ctrllimited = motor.forcelimited = "true"
    motor.ctrlrange = motor.forcerange = [-effort, effort]
    return motor


def _index(alone: mujoco.MjModel, actuator: Any) -> int | None:
    name = actuator.full_identifier or ""
    found = mujoco.mj_name2id(alone, int(mujoco.mjtObj.mjOBJ_ACTUATOR), name)
    return int(found) if found >= 0 else None


def _pulls_only(tendon: Any, names: set[str]) -> bool:
    pulled = [getattr(child, "joint", None) for child in tendon.all_children()]
    return bool(pulled) and all(
        joint is not None and joint.full_identifier in names for joint in pulled
    )
