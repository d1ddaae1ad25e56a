"""The visible geometry of a model has sizes, colours and poses of its geoms."""

import mujoco
import numpy as np
import pytest
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from bt_manip_recording import CellScene
from bt_manip_recording.foxglove import geometry_message

XML = """
<mujoco>
  <asset>
    <material name="blue" rgba="0 0 1 .5"/>
    <texture name="t" type="2d" builtin="checker" rgb1=".2 0 0" rgb2="1 1 1" width="8" height="8"/>
    <material name="textured" texture="t" rgba=".5 1 .25 .8"/>
    <mesh name="roof" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>
  </asset>
  <worldbody>
    <camera name="above" pos=".1 -.2 3" quat=".1 .7 -.1 .7" fovy="30"/>
    <geom type="plane" size="0 2 1"/>
    <body name="thing/" pos=".3 -.4 1" quat=".5 .5 -.5 .5"><freejoint/>
      <geom type="box" size=".1 .2 .3" rgba="1 0 0 1" pos=".4 -.5 .6" quat=".1 .7 -.1 .7"/>
      <geom type="sphere" size=".1" pos="0 0 1" material="blue"/>
      <geom type="ellipsoid" size=".1 .2 .3"/>
      <geom type="cylinder" size=".1 .2" material="textured"/>
      <geom type="box" size="1 1 1" group="3"/>
      <body name="thing/part"><geom type="mesh" mesh="roof"/></body>
    </body>
    <body name="pill/">
      <geom type="capsule" size=".1 .2" pos=".4 -.5 .6" quat=".1 .7 -.1 .7"/>
    </body>
  </worldbody>
</mujoco>"""

TURN = [0.1, 0.7, -0.1, 0.7]


@pytest.fixture
def model():
    return mujoco.MjModel.from_xml_string(XML)


@pytest.fixture
def scene(model):
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return CellScene(model, data)


def test_entities_have_the_visible_shapes_of_their_bodies_with_their_colours(scene):
    assert list(scene.entities()) == ["world", "thing", "pill"]
    shapes = scene.shapes("thing")
    assert list(shapes) == ["thing", "thing/part"]
    textured = pytest.approx((0.3, 0.5, 0.125, 0.8), abs=1e-3)
    assert [(one.kind, one.size, one.rgba) for one in shapes["thing"]] == [
        ("box", (0.2, 0.4, 0.6), (1.0, 0.0, 0.0, 1.0)),
        ("ellipsoid", (0.2, 0.2, 0.2), (0.0, 0.0, 1.0, 0.5)),
        ("ellipsoid", (0.2, 0.4, 0.6), (0.5, 0.5, 0.5, 1.0)),
        ("cylinder", (0.2, 0.2, 0.4), textured),
    ]
    assert shapes["thing"][1].position.tolist() == [0.0, 0.0, 1.0]


def test_a_vertex_at_a_sharp_edge_is_there_for_each_side(scene):
    (roof,) = scene.shapes("thing")["thing/part"]
    assert roof.kind == "mesh" and roof.triangles is not None
    assert roof.triangles.faces.shape == (4, 3)
    corners = roof.triangles.vertices[roof.triangles.faces]
    volume = np.linalg.det(corners).sum() / 6.0
    assert abs(volume) == pytest.approx(1.0 / 6.0)


def test_a_plane_is_a_thin_box_and_a_capsule_three_shapes(scene):
    (floor,) = scene.shapes("world")["world"]
    assert floor.kind == "box" and floor.size == (10.0, 4.0, 1e-4)
    cylinder, *ends = scene.shapes("pill")["pill"]
    assert (cylinder.kind, cylinder.size) == ("cylinder", (0.2, 0.2, 0.4))
    axis, places = np.array([0.96, -0.28, 0.0]), [end.position for end in ends]  # z by TURN
    expected = [(0.4, -0.5, 0.6) - 0.2 * axis, (0.4, -0.5, 0.6) + 0.2 * axis]
    np.testing.assert_allclose(places, expected, atol=1e-9)
    assert {(end.kind, end.size) for end in ends} == {("ellipsoid", (0.2, 0.2, 0.2))}


def test_messages_for_foxglove_have_sizes_and_colours_of_the_shapes(scene):
    def entities(name):
        return SceneUpdate.FromString(geometry_message(scene.shapes(name), 0)).entities

    thing, _ = entities("thing")
    (box,), (ball, ellipsoid), (cylinder,) = thing.cubes, thing.spheres, thing.cylinders
    assert (box.size.x, box.size.y, box.size.z) == (0.2, 0.4, 0.6)
    assert (box.color.r, box.color.g, box.color.b, box.color.a) == (1.0, 0.0, 0.0, 1.0)
    assert ball.pose.position.z == 1.0 and ball.size.x == 0.2
    assert (ellipsoid.size.x, ellipsoid.size.y, ellipsoid.size.z) == (0.2, 0.4, 0.6)
    assert cylinder.size.z == 0.4
    (pill,) = entities("pill")
    assert [round(end.size.y, 6) for end in pill.spheres] == [0.2, 0.2]
    at, turn = box.pose.position, box.pose.orientation
    assert [at.x, at.y, at.z, turn.w, turn.x, turn.y, turn.z] == [0.4, -0.5, 0.6, *TURN]
    (floor,) = entities("world")
    assert floor.frame_id == "world" and floor.cubes[0].size.x == 10.0


def test_looks_differ_after_a_change_of_colour(model, scene):
    before = scene.entities()
    assert scene.entities() == before
    model.geom_rgba[1] = (0.0, 1.0, 0.0, 1.0)
    changed = [name for name, looks in scene.entities().items() if looks != before[name]]
    assert changed == ["thing"]


def test_cameras_have_the_frame_of_their_body(scene):
    (camera,) = scene.cameras
    assert (camera.name, camera.frame, camera.fovy) == ("above", "world", 30.0)
    assert [*camera.position, *camera.quat_wxyz] == [0.1, -0.2, 3.0, *TURN]
