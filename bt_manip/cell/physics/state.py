"""The state of a compiled physics: as a vector, and copied by name to another model."""

from collections.abc import Callable, Container, Iterator
from functools import partial

import mujoco
import numpy as np

from ..naming import entity_of

INTEGRATION = int(mujoco.mjtState.mjSTATE_INTEGRATION.value)  # faster than the enum
# Width of a joint in qpos and qvel by type: free, ball, slide, hinge.
_QPOS_WIDTH = (7, 4, 1, 1)
_DOF_WIDTH = (6, 3, 1, 1)


def integration_state(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Return MuJoCo's integration state, on which the next step depends."""  # (nstate,)
    state = np.empty(mujoco.mj_stateSize(model, INTEGRATION))
    mujoco.mj_getState(model, data, state, INTEGRATION)
    return state


def set_integration_state(model: mujoco.MjModel, data: mujoco.MjData, state: np.ndarray) -> None:
    """Set an integration state and recompute all derived quantities.

    Raises:
        ValueError: If the state is of a model of another size, or not finite.
    """
    size = mujoco.mj_stateSize(model, INTEGRATION)
    if state.shape != (size,):
        raise ValueError(f"a state of this model has {size} numbers, got {state.shape}")
    if not np.isfinite(state).all():
        raise ValueError("a number of the state is not finite")
    mujoco.mj_setState(model, data, state, INTEGRATION)
    mujoco.mj_forward(model, data)


def carry_state(
    old_model: mujoco.MjModel,
    old_data: mujoco.MjData,
    new_model: mujoco.MjModel,
    new_data: mujoco.MjData,
    *,
    except_entities: Container[str] = (),
) -> None:
    """Copy the state of all elements of both models, matched by name, bit for bit.

    Elements of only the new model keep their initial state. Derived quantities are not recomputed.

    Args:
        old_model: Model of the state.
        old_data: The state.
        new_model: Model to copy it to.
        new_data: Changed in place.
        except_entities: Entities whose state is not copied.
    """
    shared = partial(_pairs, except_entities)
    new_data.time = old_data.time
    for old, new in shared(old_model, new_model, mujoco.mjtObj.mjOBJ_JOINT, old_model.njnt):
        kind = int(old_model.jnt_type[old])
        if kind != int(new_model.jnt_type[new]):
            continue
        _copy(old_data.qpos, old_model.jnt_qposadr[old], new_data.qpos,
              new_model.jnt_qposadr[new], _QPOS_WIDTH[kind])  # fmt: skip
        source, target = old_model.jnt_dofadr[old], new_model.jnt_dofadr[new]
        for field in ("qvel", "qacc_warmstart", "qacc", "qfrc_applied"):
            _copy(getattr(old_data, field), source, getattr(new_data, field), target,
                  _DOF_WIDTH[kind])  # fmt: skip
    for old, new in shared(old_model, new_model, mujoco.mjtObj.mjOBJ_BODY, old_model.nbody):
        new_data.xfrc_applied[new] = old_data.xfrc_applied[old]
        source, target = old_model.body_mocapid[old], new_model.body_mocapid[new]
        if source >= 0 and target >= 0:
            new_data.mocap_pos[target] = old_data.mocap_pos[source]
            new_data.mocap_quat[target] = old_data.mocap_quat[source]
    for old, new in shared(old_model, new_model, mujoco.mjtObj.mjOBJ_ACTUATOR, old_model.nu):
        new_data.ctrl[new] = old_data.ctrl[old]
        width = int(old_model.actuator_actnum[old])
        if width and width == int(new_model.actuator_actnum[new]):
            _copy(old_data.act, old_model.actuator_actadr[old], new_data.act,
                  new_model.actuator_actadr[new], width)  # fmt: skip
    for old, new in shared(old_model, new_model, mujoco.mjtObj.mjOBJ_EQUALITY, old_model.neq):
        new_data.eq_active[new] = old_data.eq_active[old]
    for old, new in shared(old_model, new_model, mujoco.mjtObj.mjOBJ_SENSOR, old_model.nsensor):
        width = int(old_model.sensor_dim[old])
        if width == int(new_model.sensor_dim[new]):
            _copy(old_data.sensordata, old_model.sensor_adr[old], new_data.sensordata,
                  new_model.sensor_adr[new], width)  # fmt: skip


def _pairs(
    except_entities: Container[str],
    old_model: mujoco.MjModel,
    new_model: mujoco.MjModel,
    kind: mujoco.mjtObj,
    count: int,
) -> Iterator[tuple[int, int]]:
    """Pair the ids of elements with equal names; unnamed elements are skipped."""
    name: Callable[..., str | None] = mujoco.mj_id2name
    for old in range(count):
        label = name(old_model, kind, old)
        if not label or entity_of(label) in except_entities:
            continue
        new = mujoco.mj_name2id(new_model, kind, label)
        if new >= 0:
            yield old, new


def _copy(
    source: np.ndarray, source_adr: int, target: np.ndarray, target_adr: int, width: int
) -> None:
    target[target_adr : target_adr + width] = source[source_adr : source_adr + width]
