"""What is compiled is PyMJCF's model, however little of it is written anew."""

import gc

import mujoco
import numpy as np
import pytest
from dm_control import composer, mjcf
from lxml import etree

from bt_manip.cell import Arena, Basket, Cell, CellError, Cube, Table
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from bt_manip.spatial import pose

# MuJoCo keeps hulls and search helpers of meshes that only seen geoms use, or drops them, as its
# cache has it; no step looks at them. Names of files are names of files.
UNUSED = ("_sizes", "mesh_graph", "mesh_extrema", "mesh_poly", "mesh_path", "path")


NESTED = """
<mujoco model="nested">
  <default>
    <geom friction="0.3"/>
    <default class="soft"><geom solref="0.05 1"/></default>
  </default>
  <asset>
    <mesh name="blob" file="blob.obj" inertia="shell"/>
    <mesh name="tetra" vertex="0 0 0 .1 0 0 0 .1 0 0 0 .1" scale="1 2 1"/>
  </asset>
  <worldbody>
    <body name="arm" pos="0 0 1" childclass="soft">
      <joint name="swing" axis="0 1 0"/>
      <geom type="mesh" mesh="tetra" mass="1"/>
      <geom type="mesh" mesh="blob" mass="1"/>
      <geom name="tip" size="0.03" pos="0.3 0 0" mass="0.2"/>
    </body>
  </worldbody>
  <actuator><motor name="push" joint="swing"/></actuator>
  <sensor><jointpos joint="swing"/></sensor>
</mujoco>"""


def nested() -> composer.Entity:
    """Return a thing with a part attached to it, defaults, a file, a sensor and an actuator."""
    points = np.random.default_rng(0).normal(size=(20, 3)) * 0.05
    obj = "\n".join("v {} {} {}".format(*p) for p in points)
    faces = "\n".join(f"f {i} {i + 1} {i + 2}" for i in range(1, 18))
    root = mjcf.from_xml_string(NESTED, assets={"blob.obj": f"{obj}\n{faces}\n".encode()})
    part = mjcf.RootElement(model="part")
    part.worldbody.add("geom", name="knob", size=(0.01,), mass=0.1)
    root.find("body", "arm").add("site", name="mount").attach(part)
    return composer.ModelWrapperEntity(root)


@pytest.fixture(scope="module")
def robot():
    return Robot(panda(), gripper=TwoFingerGripper)


def differences(model, other):
    """Name the arrays in which two models differ."""
    return [
        name
        for name in dir(model)
        if isinstance(getattr(model, name), np.ndarray)
        and not name.startswith(UNUSED)
        and getattr(model, name).tobytes() != getattr(other, name).tobytes()
    ]


def assert_is_pymjcfs(cell):
    whole = cell.arena.mjcf_model
    xml = etree.fromstring(whole.to_xml_string())
    for joint in xml.findall("worldbody/body/freejoint"):  # its body's pose is part of the state
        for attribute in ("pos", "quat"):
            joint.getparent().attrib.pop(attribute, None)
    by_pymjcf = mujoco.MjModel.from_xml_string(etree.tostring(xml), whole.get_assets())
    assert differences(by_pymjcf, cell.model) == []
    assert by_pymjcf.names == cell.model.names


def test_a_cell_with_a_robot_compiles_to_pymjcfs_model(robot):
    cell = Cell()
    with cell.editing():
        for i, entity in enumerate((Table(), robot, nested(), Basket())):
            cell.add(entity, pose((2 * i, 0, 0)))
    cell.add(Cube(), pose((0.3, 0.1, 1.04)))
    cell.remove("table")
    cell.add(Cube(), pose((0.3, -0.1, 1.04)))
    assert_is_pymjcfs(cell)


def fill_part(cell, thing):
    part = mjcf.RootElement(model="late")
    thing.mjcf_model.find("body", "arm").add("site", name="late").attach(part)
    with cell.editing():
        pass
    part.worldbody.add("geom", name="late", size=(0.02,), mass=0.1)


def edit_arena(cell, thing):
    cell.arena.mjcf_model.find("geom", "floor").friction = (0.2,)
    cell.arena.mjcf_model.default.geom.margin = 0.001
    cell.arena.mjcf_model.option.gravity = (0, 0, -1)


def attach_by_hand(cell, thing):
    model = mjcf.from_xml_string(
        '<mujoco model="raw"><asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
        '<worldbody><geom type="mesh" mesh="m"/></worldbody></mujoco>'
    )
    cell.arena.mjcf_model.attach(model)


EDITS = [
    fill_part,
    edit_arena,
    attach_by_hand,
    lambda cell, thing: mjcf.get_attachment_frame(thing.mjcf_model).set_attributes(pos=(1, 2, 3)),
    lambda cell, thing: thing.mjcf_model.find("geom", "part/knob").set_attributes(mass=0.7),
    lambda cell, thing: thing.mjcf_model.find("geom", "part/knob").root.worldbody.add(
        "geom", size=(0.02,), mass=0.1
    ),
    lambda cell, thing: thing.mjcf_model.default.geom.set_attributes(friction=(0.9,)),
    lambda cell, thing: thing.mjcf_model.find("geom", "tip").set_attributes(name="end"),
    lambda cell, thing: thing.mjcf_model.find("geom", "tip").remove(),
]


@pytest.mark.parametrize("edit", EDITS)
def test_what_is_edited_by_hand_is_in_the_next_compile(edit):
    cell, thing = Cell(), nested()
    cell.add(thing)
    cell.add(Cube(), pose((1, 0, 1)))
    before = cell.model
    with cell.editing():
        edit(cell, thing)
    assert differences(before, cell.model) or before.names != cell.model.names
    assert_is_pymjcfs(cell)


def test_only_what_is_new_is_written(monkeypatch):
    cell = Cell()
    cell.add(nested())
    written, read = [], mjcf.RootElement.get_assets  # once for each model that is written
    monkeypatch.setattr(
        mjcf.RootElement, "get_assets", lambda self: written.append(self.model) or read(self)
    )
    cell.add(Cube(), pose((1, 0, 1)))
    cell.add(Cube(), pose((2, 0, 1)))
    cell.remove("cube")
    assert written == ["cube", "cube_1"]


def test_a_model_that_mujoco_refuses_is_named():
    arena = Arena()
    cell, thing = Cell(arena), nested()
    thing.mjcf_model.worldbody.add("body", name="ghost").add("joint", type="slide")
    with pytest.raises(CellError, match="'nested' cannot be added: 'nested/ghost' moves, .*mass"):
        cell.add(thing)


def test_coming_and_going_leaves_nothing_behind():
    cell = Cell()
    cell.compiles_kept = 2

    def objects_after(times):
        for _ in range(times):
            cell.remove(cell.add(Cube(), pose((1, 0, 1))))
        gc.collect()
        return len(gc.get_objects())

    before = objects_after(3)  # as many physics are kept as ever
    assert objects_after(3) - before < 20  # an entity alone is some hundreds
