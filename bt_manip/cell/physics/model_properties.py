"""Properties of a compiled model that can be overridden."""

from collections.abc import Callable
from typing import Any, NamedTuple

import mujoco
import numpy as np

from bt_manip.exceptions import did_you_mean

from ..exceptions import CellError

Ids = np.ndarray
"""Ids of bodies, of a light or of a camera."""


class ModelProperty(NamedTuple):
    """A property that can be changed without a compile."""

    read: Callable[[mujoco.MjModel, Ids], Any]
    """Reads the value from a model."""
    write: Callable[[mujoco.MjModel, mujoco.MjModel, Ids, np.ndarray], None]
    """Sets the value: ``write(model, nominal, ids, value)``, given the compiled model."""
    allowed: Callable[[np.ndarray], bool]
    """Returns whether a value of the right shape is possible."""
    what: str
    """The possible values with their unit, for messages."""


# Bodies of an entity


def _geoms(model: mujoco.MjModel, bodies: Ids, *, seen: bool) -> np.ndarray:
    """Return the visible geoms of bodies, or the collision geoms."""
    solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    wanted = model.geom_group <= 2 if seen else solid
    geoms = np.flatnonzero(np.isin(model.geom_bodyid, bodies) & wanted)
    if not len(geoms):
        raise CellError("it has no visible shapes" if seen else "it has no collision geometry")
    return geoms


def _actuators(model: mujoco.MjModel, bodies: Ids) -> np.ndarray:
    """Return the actuators on joints of bodies whose force is affine in the control."""
    joints = np.flatnonzero(np.isin(model.jnt_bodyid, bodies))
    tendons = np.flatnonzero(
        [
            np.isin(model.wrap_objid[adr : adr + n], joints).any()
            for adr, n in zip(model.tendon_adr, model.tendon_num, strict=True)
        ]
    )
    kinds, targets = model.actuator_trntype, model.actuator_trnid[:, 0]
    on_joint = np.isin(
        kinds, (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    )
    on_tendon = kinds == int(mujoco.mjtTrn.mjTRN_TENDON)
    affine = model.actuator_gaintype <= int(mujoco.mjtGain.mjGAIN_AFFINE)
    mine = (on_joint & np.isin(targets, joints)) | (on_tendon & np.isin(targets, tendons))
    found = np.flatnonzero(mine & affine)
    if not len(found):
        raise CellError("it has no actuators")
    return found


def _mass(model: mujoco.MjModel, bodies: Ids) -> float:
    mass = float(model.body_mass[bodies].sum())
    if not mass > 0.0:
        raise CellError("it has no mass")
    return mass


def _set_mass(model: mujoco.MjModel, nominal: mujoco.MjModel, bodies: Ids, value: Any) -> None:
    share = float(value) / _mass(nominal, bodies)
    model.body_mass[bodies] = nominal.body_mass[bodies] * share
    model.body_inertia[bodies] = nominal.body_inertia[bodies] * share


def _friction(model: mujoco.MjModel, bodies: Ids) -> float:
    return float(model.geom_friction[_geoms(model, bodies, seen=False), 0].max())


def _set_friction(model: mujoco.MjModel, nominal: mujoco.MjModel, bodies: Ids, value: Any) -> None:
    geoms = _geoms(nominal, bodies, seen=False)
    sliding = nominal.geom_friction[geoms, 0]
    most = sliding.max()
    # The largest is assigned directly: value * most / most may differ in the last digit.
    model.geom_friction[geoms, 0] = np.where(
        sliding == most, value, value * sliding / (most or 1.0)
    )


def _colour(model: mujoco.MjModel, bodies: Ids) -> np.ndarray:  # (4,)
    geom = _geoms(model, bodies, seen=True)[0]
    material = model.geom_matid[geom]
    return (model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]).astype(float)


def _set_colour(model: mujoco.MjModel, nominal: mujoco.MjModel, bodies: Ids, value: Any) -> None:
    geoms = _geoms(nominal, bodies, seen=True)
    model.geom_matid[geoms] = -1
    model.geom_rgba[geoms] = value


def _set_gain(model: mujoco.MjModel, nominal: mujoco.MjModel, bodies: Ids, value: Any) -> None:
    actuators = _actuators(nominal, bodies)
    for name in ("actuator_gainprm", "actuator_biasprm"):
        getattr(model, name)[actuators, :3] = (
            getattr(nominal, name)[actuators, :3] * np.asarray(value)[:, None]
        )


# MuJoCo's dry friction slips: with defaults, at 0.9 m/s for 50 N on a cube of 57 g.
_EXACT = 0.9999  # [-] impedance; reduces the slip to 1/1000
_STIFF = 0.004  # [s] time constant; reduces the slip to 1/5


def _dofs(model: mujoco.MjModel, bodies: Ids) -> np.ndarray:
    """Return the degrees of freedom of bodies."""
    dofs = np.flatnonzero(np.isin(model.dof_bodyid, bodies))
    if not len(dofs):
        raise CellError("it does not move")
    return dofs


def _set_joint_friction(
    model: mujoco.MjModel, nominal: mujoco.MjModel, bodies: Ids, value: Any
) -> None:
    dofs = _dofs(nominal, bodies)
    more = dofs[np.asarray(value) > nominal.dof_frictionloss[dofs]]
    model.dof_frictionloss[dofs] = value
    model.dof_solimp[more, :2], model.dof_solref[more, 0] = _EXACT, _STIFF


# Lights


def _set_brightness(model: mujoco.MjModel, nominal: mujoco.MjModel, light: Ids, value: Any) -> None:
    for name in ("light_diffuse", "light_ambient", "light_specular"):  # on top of a new colour
        field = getattr(model, name)
        field[light[0]] = field[light[0]] * value


def _set_direction(model: mujoco.MjModel, nominal: mujoco.MjModel, light: Ids, value: Any) -> None:
    model.light_dir[light[0]] = value / np.linalg.norm(value)


# Cameras


def _set_rotation(model: mujoco.MjModel, nominal: mujoco.MjModel, camera: Ids, value: Any) -> None:
    turned = nominal.cam_quat[camera[0]].copy()
    mujoco.mju_quatIntegrate(turned, value, 1.0)
    model.cam_quat[camera[0]] = turned


def _vector(field: str) -> Callable[[mujoco.MjModel, Ids], np.ndarray]:
    return lambda model, ids: np.array(getattr(model, field)[ids[0]], dtype=float)


def _put(field: str) -> Callable[[mujoco.MjModel, mujoco.MjModel, Ids, Any], None]:
    def write(model: mujoco.MjModel, nominal: mujoco.MjModel, ids: Ids, value: Any) -> None:
        getattr(model, field)[ids[0]] = value

    return write


def _any(value: np.ndarray) -> bool:
    return True


def _positive(value: np.ndarray) -> bool:
    return bool((value > 0.0).all())


def _not_negative(value: np.ndarray) -> bool:
    return bool((value >= 0.0).all())


def _share(value: np.ndarray) -> bool:
    return bool(((value >= 0.0) & (value <= 1.0)).all())


MAX_MASS = 1e10  # [kg]
ENTITY, LIGHT, CAMERA = "entity", "light", "camera"

PROPERTIES: dict[str, dict[str, ModelProperty]] = {
    ENTITY: {
        "mass": ModelProperty(
            _mass, _set_mass, lambda v: bool(((v > 0.0) & (v <= MAX_MASS)).all()),
            f"a number above 0 and at most {MAX_MASS:g} [kg]",
        ),
        "friction": ModelProperty(_friction, _set_friction, _positive, "a positive number"),
        "colour": ModelProperty(_colour, _set_colour, _share, "3 or 4 numbers from 0 to 1"),
        "gain": ModelProperty(
            lambda model, bodies: np.ones(len(_actuators(model, bodies))), _set_gain, _positive,
            "a positive factor, or one an actuator",
        ),
        "joint_friction": ModelProperty(
            lambda model, bodies: model.dof_frictionloss[_dofs(model, bodies)],
            _set_joint_friction, _not_negative,
            "a number of at least 0 for each degree of freedom [N m or N]",
        ),
    },
    LIGHT: {
        "colour": ModelProperty(
            _vector("light_diffuse"), _put("light_diffuse"), _share, "3 numbers from 0 to 1",
        ),
        "brightness": ModelProperty(
            lambda model, ids: 1.0, _set_brightness, _not_negative, "a factor that is not negative"
        ),
        "position": ModelProperty(_vector("light_pos"), _put("light_pos"), _any, "3 numbers [m]"),
        "direction": ModelProperty(
            _vector("light_dir"), _set_direction, lambda v: bool(v.any()), "3 numbers, not all 0"
        ),
    },
    CAMERA: {
        "position": ModelProperty(_vector("cam_pos"), _put("cam_pos"), _any, "3 numbers [m]"),
        "rotation": ModelProperty(
            lambda model, ids: np.zeros(3), _set_rotation, _any,
            "a rotation about the camera's own axes, 3 numbers [rad]",
        ),
        "fovy": ModelProperty(
            lambda model, ids: float(model.cam_fovy[ids[0]]), _put("cam_fovy"),
            lambda v: bool(0 < v < 180),
            "an angle of view between 0 and 180 [degrees]",
        ),
    },
}  # fmt: skip
"""The properties by kind of element and name; written in this order."""


def find_property(kind: str, name: str) -> ModelProperty:
    """Return a property of a kind of element by name.

    Raises:
        CellError: If there is none.
    """
    known = PROPERTIES[kind]
    if name not in known:
        what = {ENTITY: "of an entity", LIGHT: "of a light", CAMERA: "of a camera"}[kind]
        near = did_you_mean(name, known)
        raise CellError(f"'{name}' {what} cannot be overridden{near}; {', '.join(known)} can")
    return known[name]
