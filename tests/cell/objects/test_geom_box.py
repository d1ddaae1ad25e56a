"""The bounding box of a turned geom, against points of its surface."""

import mujoco
import numpy as np
import pytest

from bt_manip.cell.objects import geom_box

SPHERE = np.random.default_rng(0).normal(size=(20000, 3))
SPHERE /= np.linalg.norm(SPHERE, axis=1)[:, None]
ENDS = np.sign(SPHERE[:, 2:]) * [0.0, 0.0, 1.0]
RIM = SPHERE[:, :2] / np.linalg.norm(SPHERE[:, :2], axis=1)[:, None]
SURFACES = {
    "sphere": ("0.03", 0.03 * SPHERE),
    "capsule": ("0.02 0.05", 0.02 * SPHERE + 0.05 * ENDS),
    "cylinder": ("0.02 0.05", np.column_stack([0.02 * RIM, 0.05 * ENDS[:, 2]])),
    "ellipsoid": ("0.02 0.03 0.05", SPHERE * [0.02, 0.03, 0.05]),
    "box": ("0.02 0.03 0.05", np.sign(SPHERE) * [0.02, 0.03, 0.05]),
}


@pytest.mark.parametrize("kind", SURFACES)
def test_the_box_of_a_geom_is_the_smallest_around_its_surface(kind):
    size, surface = SURFACES[kind]
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><geom type="{kind}" size="{size}" pos="0.3 -0.2 0.1" '
        'quat="0.8 0.3 -0.4 0.33"/></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    points = surface @ data.geom_xmat[0].reshape(3, 3).T + data.geom_xpos[0]
    lower, upper = geom_box(model, data, 0)
    assert (lower <= points.min(axis=0) + 1e-12).all()
    assert (upper >= points.max(axis=0) - 1e-12).all()
    assert lower == pytest.approx(points.min(axis=0), abs=1e-4)
    assert upper == pytest.approx(points.max(axis=0), abs=1e-4)
