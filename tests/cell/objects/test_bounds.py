"""The bounding box of a turned geom, against points of its surface."""

from itertools import product

import mujoco
import numpy as np
import pytest

from bt_manip.cell.objects import geom_box
from bt_manip.cell.objects.bounds import bounds_of
from bt_manip.spatial import pose

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
    "mesh": ("1", np.array([[0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3], [-0.1, -0.2, -0.1]])),
    "hfield": ("1", np.array(list(product((-0.2, 0.2), (-0.3, 0.3), (-0.05, 0.1))))),
}
ASSETS = """<asset><mesh name="other" vertex="0 0 0 9 0 0 0 9 0 0 0 9"/>
<mesh name="it" vertex=".1 0 0 0 .2 0 0 0 .3 -.1 -.2 -.1"/>
<hfield name="it" nrow="2" ncol="2" size=".2 .3 .1 .05" elevation="0 1 1 0"/></asset>"""


@pytest.mark.parametrize("T_wf", [None, pose((0.2, 0.1, -0.3), (0.6, -0.2, 0.7, 0.1))])
@pytest.mark.parametrize("kind", SURFACES)
def test_the_box_of_a_geom_is_the_smallest_around_its_surface(kind, T_wf):
    size, surface = SURFACES[kind]
    asset = f'{kind}="it"' if kind in ("mesh", "hfield") else ""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco>{ASSETS}<worldbody><geom type="{kind}" size="{size}" pos="0.3 -0.2 0.1" {asset} '
        'quat="0.8 0.3 -0.4 0.33"/><geom type="mesh" mesh="other"/></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    T_wg = pose((0.3, -0.2, 0.1), (0.8, 0.3, -0.4, 0.33))
    T = T_wg if T_wf is None else T_wf.inverse() * T_wg
    points = surface @ T.rotation.T + T.translation
    lower, upper = geom_box(model, data, 0, T_wf)
    assert (lower <= points.min(axis=0) + 1e-7).all()
    assert (upper >= points.max(axis=0) - 1e-7).all()
    assert lower == pytest.approx(points.min(axis=0), abs=1e-4)
    assert upper == pytest.approx(points.max(axis=0), abs=1e-4)


@pytest.mark.parametrize(
    ("solid", "lower", "upper"),
    [
        ("1 0", (0.9, 1.9, 2.9), (1.1, 2.1, 3.1)),
        ("0 1", (0.9, 1.9, 2.9), (1.1, 2.1, 3.1)),
        ("0 0", (-1.2, -0.2, 0.3), (1.1, 2.1, 3.1)),
    ],
)
def test_a_model_is_bounded_by_what_collides_or_else_by_all_but_planes(solid, lower, upper):
    contype, conaffinity = solid.split()
    bounds = bounds_of(
        mujoco.MjModel.from_xml_string(
            f"""<mujoco><worldbody><geom type="plane" size="9 9 1"/>
            <geom size=".1" pos="1 2 3" contype="{contype}" conaffinity="{conaffinity}"/>
            <geom size=".2" pos="-1 0 .5" contype="0" conaffinity="0"/></worldbody></mujoco>"""
        )
    )
    assert (*bounds.lower, *bounds.upper) == pytest.approx((*lower, *upper))
    assert bounds.size == pytest.approx(np.subtract(upper, lower))
    assert bounds.centre == pytest.approx(np.add(upper, lower) / 2)
