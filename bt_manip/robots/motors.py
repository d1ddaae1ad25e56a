"""Replacement of a model's actuators by motors."""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from dm_control import mjcf

_ACTUATOR = int(mujoco.mjtObj.mjOBJ_ACTUATOR)


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
            i = mujoco.mj_name2id(alone, _ACTUATOR, actuator.full_identifier or "")
            plain = i >= 0 and is_motor(alone, i) and alone.actuator_gear[i, 0] == 1.0
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


def _motor(root: mjcf.RootElement, element: Any, effort: float, motor: Any) -> Any:
    if motor is None:
        what = "tendon" if element.tag in ("fixed", "spatial") else "joint"
        motor = element.root.actuator.add(
            "motor", name=f"{element.name}_motor", gear=[1.0], **{what: element}
        )
    motor.ctrllimited = motor.forcelimited = "true"
    motor.ctrlrange = motor.forcerange = [-effort, effort]
    return motor


def _pulls_only(tendon: Any, names: set[str]) -> bool:
    pulled = [getattr(child, "joint", None) for child in tendon.all_children()]
    return bool(pulled) and all(
        joint is not None and joint.full_identifier in names for joint in pulled
    )


def effort_limit(mj_model: mujoco.MjModel, target: int, kind: str = "joint") -> float:
    """Return the maximum effort of the actuators of a target, infinite when unbounded.

    Args:
        mj_model: The model.
        target: Id of a joint or a tendon.
        kind: ``"joint"`` or ``"tendon"``.
    """
    bound = np.inf
    if kind == "joint" and mj_model.jnt_actfrclimited[target]:
        bound = float(np.abs(mj_model.jnt_actfrcrange[target]).min())
    transmission = mujoco.mjtTrn.mjTRN_JOINT if kind == "joint" else mujoco.mjtTrn.mjTRN_TENDON
    moves = mj_model.actuator_trntype == int(transmission)
    for i in np.flatnonzero(moves & (mj_model.actuator_trnid[:, 0] == target)):
        gear = abs(float(mj_model.actuator_gear[i, 0]))
        if mj_model.actuator_forcelimited[i]:
            bound = min(bound, gear * float(np.abs(mj_model.actuator_forcerange[i]).min()))
        if mj_model.actuator_ctrllimited[i] and is_motor(mj_model, int(i)):
            bound = min(bound, gear * float(np.abs(mj_model.actuator_ctrlrange[i]).min()))
    return bound


def is_motor(mj_model: mujoco.MjModel, actuator: int) -> bool:
    """Return whether an actuator's force equals its control signal."""
    return (
        int(mj_model.actuator_gaintype[actuator]) == int(mujoco.mjtGain.mjGAIN_FIXED)
        and int(mj_model.actuator_biastype[actuator]) == int(mujoco.mjtBias.mjBIAS_NONE)
        and int(mj_model.actuator_dyntype[actuator]) == int(mujoco.mjtDyn.mjDYN_NONE)
        and float(mj_model.actuator_gainprm[actuator, 0]) == 1.0
    )
