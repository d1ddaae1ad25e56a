"""Textures are where MuJoCo's renderer draws them."""

import mujoco
import numpy as np
import pytest

from bt_manip_recording import CellScene

XML = """
<mujoco>
  <visual>
    <headlight ambient="0 0 0" diffuse="0 0 0" specular="0 0 0"/>
    <quality shadowsize="0"/>
  </visual>
  <asset>
    <texture name="colours" type="2d" builtin="flat" width="64" height="64"/>
    <material name="material" texture="colours" emission="1" specular="0" {material}/>
    <mesh name="roof" vertex="-.2 -.1 0  .2 -.1 0  .2 .1 0  -.2 .1 0  0 0 .1"
          texcoord=".1 .2  .9 .2  .9 .7  .1 .7  .4 .5"
          face="0 1 4  1 2 4  2 3 4  3 0 4  0 3 2  0 2 1"/>
  </asset>
  <worldbody>
    <geom {geom} material="material"/>
    <camera name="above" pos=".5 -.4 .7" xyaxes=".4 .5 0 -.35 .28 .41"/>
  </worldbody>
</mujoco>"""

GEOMS = {
    "box": 'type="box" size=".2 .1 .05"',
    "plane": 'type="plane" size=".2 .1 .05"',
    "mesh": 'type="mesh" mesh="roof"',
}

MATERIALS = ('texrepeat="1.5 .7"', 'texrepeat="3 4" texuniform="true"')

SIZE = 300  # of the picture [pixels]


@pytest.fixture(params=MATERIALS)
def make_model(request):
    def make(kind: str) -> mujoco.MjModel:
        text = XML.format(geom=GEOMS[kind], material=request.param)
        model = mujoco.MjModel.from_xml_string(text)
        colours = model.tex_data.reshape(64, 64, 3)
        colours[..., 0] = 4 * np.arange(64)
        colours[..., 1] = 4 * np.arange(64)[:, None]
        colours[..., 2] = 128
        return model

    return make


@pytest.mark.parametrize("kind", GEOMS)
def test_a_texture_is_where_mujoco_draws_it(opengl, make_model, kind):
    model = make_model(kind)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    (shape,) = CellScene(model, data).shapes("world")["world"]
    mesh = shape.textured
    with mujoco.Renderer(model, SIZE, SIZE) as renderer:
        renderer.update_scene(data, "above")
        drawn = renderer.render().astype(float)
    rng = np.random.default_rng(0)
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    outwards = np.cross(b - a, c - a)
    areas = np.linalg.norm(outwards, axis=1)
    if kind != "mesh":  # its normals are smooth
        assert np.all(np.sum(outwards * mesh.normals[mesh.faces[:, 0]], axis=1) > 0.0)
    faces = mesh.faces[rng.choice(len(areas), 400, p=areas / areas.sum())]
    weights = rng.dirichlet(np.ones(3), len(faces))[:, None]
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, shape.quat_wxyz)
    points = (weights @ mesh.vertices[faces])[:, 0] @ R.reshape(3, 3).T + shape.position
    normals = mesh.normals[faces].mean(axis=1) @ R.reshape(3, 3).T
    camera, axes = data.cam_xpos[0], data.cam_xmat[0].reshape(3, 3)
    seen = np.einsum("fi,fi->f", camera - points, normals) > 0.05
    x, y, z = ((points[seen] - camera) @ axes).T
    scale = SIZE / 2 / np.tan(np.deg2rad(model.cam_fovy[0]) / 2)
    shown = drawn[(SIZE / 2 + scale * y / z).astype(int), (SIZE / 2 - scale * x / z).astype(int)]
    at = (64 * (weights @ mesh.coordinates[faces])[seen, 0]).astype(int) % 64
    expected = mesh.pixels[at[:, 1], at[:, 0]]
    assert len(shown) > 100
    assert np.mean(np.abs(shown - expected).max(axis=1) < 12.0) > 0.85  # apart from edges


def test_a_texture_has_the_colour_of_its_material_and_without_coordinates_the_mean(make_model):
    model = make_model("plane")
    model.mat_rgba[0] = (0.5, 1.0, 1.0, 1.0)
    (shape,) = CellScene(model, mujoco.MjData(model)).shapes("world")["world"]
    assert shape.textured.pixels[0, -1].tolist() == [126, 0, 128]
    model.mat_rgba[0], model.geom_type[0] = 1.0, mujoco.mjtGeom.mjGEOM_ELLIPSOID
    (shape,) = CellScene(model, mujoco.MjData(model)).shapes("world")["world"]
    assert shape.textured is None
    np.testing.assert_allclose(shape.rgba, (0.5, 0.5, 0.5, 1.0), atol=0.01)
