"""Checks of the masses and inertias in model files."""

from collections.abc import Iterator

import mujoco
import numpy as np
from dm_control import mjcf

from bt_manip.cell.naming import literal_name

from .prop import value_of

_LEAST = 0.01  # share of the geometry's inertia, or of a model's mass, that counts
_NOT_POSITIVE = 1e-13  # moment of inertia [kg m^2] that was not, made so that MuJoCo takes it
_SUSPECT = 3.0  # ratio of the inertia of a body's box to that of a body that may be suspicious


def correct_inertias(
    root: mjcf.RootElement, alone: mujoco.MjModel, tolerance: float = 1.01
) -> Iterator[str]:
    """Replace impossible inertias by those of the geometry; yield a warning for each strange one.

    It is impossible if its moments are no body's, or if the mass would be outside the geoms' boxes
    along a principal axis. The geometry is that of the collision geoms, or else of all geoms.

    Args:
        root: The model, changed in place.
        alone: The same model, compiled.
        tolerance: Factor of that limit up to which inertias are kept; those of arms whose base
            parameters were identified are beyond 1.
    """
    data = mujoco.MjData(alone)
    mujoco.mj_kinematics(alone, data)
    solid: mujoco.MjModel | None = None
    for body in root.find_all("body"):
        i = mujoco.mj_name2id(alone, mujoco.mjtObj.mjOBJ_BODY, body.full_identifier)
        geoms = np.flatnonzero(alone.body_weldid[alone.geom_bodyid] == alone.body_weldid[i])
        if i < 0 or body.inertial is None or alone.body_mass[i] <= 0 or not geoms.size:
            continue
        mass, (least, _, largest) = float(alone.body_mass[i]), sorted(alone.body_inertia[i])
        axes, boxes = data.ximat[i].reshape(3, 3), alone.geom_aabb[geoms].reshape(-1, 2, 3, 1)
        turns = axes.T @ data.geom_xmat[geoms].reshape(-1, 3, 3)
        centres = (data.geom_xpos[geoms] - data.xipos[i]) @ axes + (turns @ boxes[:, 0])[..., 0]
        reach = (np.abs(centres) + (np.abs(turns) @ boxes[:, 1])[..., 0]).max(axis=0)
        radius = float(np.linalg.norm(reach))
        spread = alone.body_inertia[i].sum() / 2 - alone.body_inertia[i]  # m E[x^2] on each axis
        impossible = (spread > tolerance * mass * reach**2).any() or least < _NOT_POSITIVE
        if not impossible and largest > _SUSPECT * _LEAST * mass * radius**2:
            continue
        solid = _of_geometry(root) if solid is None else solid
        if solid is None or not solid.body_mass[i]:
            continue
        moments = solid.body_inertia[i] * mass / solid.body_mass[i]
        what = f"body '{literal_name(body.name)}': an inertia of {largest:.3g} kg m2"
        if impossible:
            del body.inertial.fullinertia
            body.inertial.diaginertia, body.inertial.quat = moments, solid.body_iquat[i]
            yield (
                f"{what} is impossible for {mass:.3g} kg within {radius:.3g} m (no body has it, or "
                f"mass outside the shape); that of its geometry is used, {moments.max():.3g} kg m2"
            )
        elif largest < _LEAST * moments.max():
            yield f"{what} is below a hundredth of its geometry's, {moments.max():.3g} kg m2"


def _of_geometry(root: mjcf.RootElement) -> mujoco.MjModel | None:
    """Return the model with all masses from its geometry; None if it does not compile."""
    spec = mujoco.MjSpec.from_string(root.to_xml_string(), assets=root.get_assets())
    spec.compiler.inertiafromgeom = int(mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE)
    for body in spec.bodies:
        solid = [geom for geom in body.geoms if geom.contype or geom.conaffinity]
        for geom in body.geoms:
            geom.mass, geom.density = np.nan, float(not solid or geom in solid)
    try:
        return spec.compile()
    except ValueError:
        return None


def invented_masses(root: mjcf.RootElement, alone: mujoco.MjModel, fixed: bool) -> str:
    """Return a warning about masses that follow from volumes; empty if the file gives the others.

    Masses of less than 1 % of the model's do not count.

    Args:
        root: The model.
        alone: The same model, compiled.
        fixed: Whether its base is fixed, so that its mass does not matter.
    """
    invented, least = {}, _LEAST * alone.body_mass.sum()
    for body in root.find_all("body"):
        i = mujoco.mj_name2id(alone, mujoco.mjtObj.mjOBJ_BODY, body.full_identifier)
        geoms = body.find_all("geom", immediate_children_only=True)
        given = [value_of(geom, key) for geom in geoms for key in ("mass", "density")]
        written = body.inertial is not None or any(given) or fixed and not alone.body_weldid[i]
        if i > 0 and alone.body_mass[i] > least and not written:
            invented[literal_name(body.name)] = float(alone.body_mass[i])
    names = ", ".join(f"'{name}' {mass:.3g} kg" for name, mass in invented.items())
    what = "no mass, so it follows from the volume at 1000 kg/m3 (water)"
    return f"the file gives {what}: {names}" if invented else ""
