"""Models as their makers wrote them: read as MuJoCo reads them, or refused with the remedy."""

import re

import mujoco
import numpy as np
import pytest
import trimesh
from dm_control import mjcf

from bt_manip.cell.objects import ModelObject
from bt_manip.exceptions import BtManipError
from bt_manip.models import ModelError, load_model
from bt_manip.robots import read_model
from tests.support.models import compiled

BODY = """<link name="b"><inertial><mass value="0.1"/><inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0"
 ixz="0" iyz="0"/></inertial>{1}<collision><geometry>{2}</geometry></collision></link>"""
BOX = '<box size="0.032 0.032 0.023"/>'
LOST = '<visual><geometry><mesh filename="gone.dae"/></geometry></visual>'


def write_urdf(path, inertia=1e-5, visual="", shape=BOX, *, head="", more="") -> str:
    """Write a robot of one link; give its path."""
    path.write_text(f'{head}<robot name="r">{BODY.format(inertia, visual, shape)}{more}</robot>')
    return str(path)


def write_groups(path, *boxes) -> None:
    """Write boxes as the groups of an OBJ file, each with its centre and size [m]."""
    lines, count = [], 0
    for i, (centre, size) in enumerate(boxes):
        box = trimesh.creation.box(size).apply_translation(centre)
        lines += [f"o part_{i}", *(f"v {x} {y} {z}" for x, y, z in box.vertices)]
        lines += [f"f {a} {b} {c}" for a, b, c in box.faces + 1 + count]
        count += len(box.vertices)
    path.write_text("\n".join(lines))


@pytest.mark.parametrize("head", [
    '<?xml version="0.0" ?>\n', "<?xml version='2.7' encoding='ISO-8859-1'?>",
    "\n\n<?xml version='1.0'?>",
])  # fmt: skip
def test_any_version_of_xml_is_read(tmp_path, head):
    assert ModelObject(write_urdf(tmp_path / "a.urdf", head=head)).mass == pytest.approx(0.1)
    path = tmp_path / "a.xml"
    path.write_text(f"{head}<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    assert ModelObject(str(path)).bounds.size == pytest.approx([2, 2, 2])


def test_xacro_is_refused_with_the_command_that_expands_it(tmp_path):
    head = '<robot name="w" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    for name, text in (
        ("a.urdf", f"{head}{BODY.format('${i}', '', BOX)}</robot>"),
        ("a.urdf.xacro", f'{head}<xacro:property name="m" value="1"/></robot>'),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(ModelError, match=f"'xacrodoc {name} -o a.expanded.urdf'"):
            load_model(str(tmp_path / name))
    (tmp_path / "expanded.urdf").write_text(f"{head}{BODY.format(1e-5, '', BOX)}</robot>")
    assert load_model(str(tmp_path / "expanded.urdf")).xml


def test_a_lost_visual_is_a_warning_and_a_lost_collision_mesh_an_error(tmp_path):
    urdf, mjcf = tmp_path / "a.urdf", tmp_path / "a.xml"
    write_urdf(urdf, visual=LOST)
    text = """<mujoco><asset><mesh name="m" file="gone.obj"/></asset><worldbody><body>
        <geom type="mesh" mesh="m" mass="0" {}/><geom size="0.02" group="3"/></body></worldbody>
        </mujoco>"""
    mjcf.write_text(text.format('contype="0" conaffinity="0"'))
    for path in (urdf, mjcf):
        thing = ModelObject(str(path))
        assert "the visual is left out" in thing.warnings[0]
        assert compiled(thing.mjcf_model).geom_group[0] <= 2  # drawn
    mjcf.write_text(text.format(""))
    with pytest.raises(Exception, match=r"gone\.obj"):
        ModelObject(str(mjcf))


def test_convex_groups_of_an_obj_have_a_hull_each(tmp_path):
    walls = [((x, 0, 0.06), (0.02, 0.1, 0.1)) for x in (-0.14, 0.14)]
    write_groups(tmp_path / "u_vhacd.obj", ((0, 0, 0), (0.3, 0.1, 0.02)), *walls)
    write_urdf(tmp_path / "u.urdf", 1e-4, shape='<mesh filename="u_vhacd.obj"/>')
    for name in ("u.urdf", "u_vhacd.obj"):
        thing = ModelObject(str(tmp_path / name))
        assert len(thing.collision_geoms) == 3
        assert thing.bounds.size == pytest.approx([0.3, 0.1, 0.12], abs=1e-6)
    volume = 0.3 * 0.1 * 0.02 + 2 * 0.02 * 0.1 * 0.1
    assert thing.mass == pytest.approx(1000 * volume)


PENDULUM = {
    "urdf": """<robot name="r"><link name="base"/><joint name="j" type="revolute">
<parent link="base"/><child link="b"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<link name="b"><inertial><mass value="0.6"/><inertia ixx="{0}" iyy="{1}" izz="{2}" ixy="{3}"
ixz="{4}" iyz="{5}"/></inertial><collision><geometry><box size="0.1 0.2 0.3"/></geometry>
</collision></link></robot>""",
    "xml": """<mujoco><compiler angle="radian"/><worldbody><body name="base"><body name="b">
<joint name="j" axis="0 1 0" range="-1 1"/><inertial pos="0 0 0" mass="0.6"
fullinertia="{0} {1} {2} {3} {4} {5}"/><geom type="box" size="0.05 0.1 0.15"/></body></body>
</worldbody></mujoco>""",
}


@pytest.mark.parametrize("kind", ["object", "robot"])
@pytest.mark.parametrize("form", ["urdf", "xml"])
@pytest.mark.parametrize("values", [
    (1, 1, 0, 0, 0, 0), (1e-3, 1e-3, 1e-3, 2e-3, 0, 0), (0, 0, 0, 0, 0, 0),
    (1, 0, 1, 0, 0, 0), (1e-3, 1e-3, 1e-3, 0, 2e-3, 0), (1e-3, 1e-3, 1e-3, 0, 0, 2e-3),
    (1e-3, 1e-3, 1e-2, 0, 0, 0),
])  # fmt: skip
def test_an_inertia_that_no_body_has_is_replaced_by_that_of_a_uniform_box(
    tmp_path, kind, form, values
):
    """A moment is at most the sum of the others; those of a box are m (b^2 + c^2) / 12."""
    path, warnings = tmp_path / f"arm.{form}", []
    path.write_text(PENDULUM[form].format(*values))
    if kind == "robot":
        model = read_model(str(path), "robot", warnings.append)[1]
    else:
        thing = ModelObject(str(path))
        model, warnings = compiled(thing.mjcf_model), thing.warnings
    body = model.body("b") if kind == "robot" else model.body(model.nbody - 1)
    assert sorted(body.inertia) == pytest.approx([0.0025, 0.005, 0.0065])
    assert body.mass == pytest.approx(0.6)
    (warning,) = warnings
    assert "is impossible for 0.6 kg" in warning and "that of its geometry is used" in warning


@pytest.mark.parametrize("form", ["urdf", "xml"])
def test_such_an_inertia_of_a_link_without_geometry_is_refused(tmp_path, form):
    path = tmp_path / f"arm.{form}"
    bare = re.sub("<(collision)>.*</collision>|<geom .*?/>", "", PENDULUM[form], flags=re.DOTALL)
    path.write_text(bare.format(1, 1, 0, 0, 0, 0))
    with pytest.raises(BtManipError, match="positive eigenvalues"):
        read_model(str(path), "robot")


def test_scale_multiplies_lengths_and_keeps_the_masses_of_the_file(tmp_path):
    write_groups(tmp_path / "mm.obj", ((0, 0, 0), (40, 60, 50)))
    huge = ModelObject(str(tmp_path / "mm.obj"))
    assert "its size is 40 x 60 x 50 m" in huge.warnings[0]
    tiny = ModelObject(f"{tmp_path}/mm.obj", scale=1.5e-5)
    assert "its size is 0.0006 x 0.0009 x 0.00075 m" in "".join(tiny.warnings)
    for thing in (
        ModelObject(f"{tmp_path}/mm.obj?scale=0.001"),
        ModelObject(f"{tmp_path}/mm.obj", scale=0.001),
    ):
        assert thing.bounds.size == pytest.approx([0.04, 0.06, 0.05])
        assert thing.mass == pytest.approx(0.12) and thing.free
        assert "the file gives no mass" in thing.warnings[0]
    assert not ModelObject(f"{tmp_path}/mm.obj", scale=0.001, mass=0.2).warnings
    write_urdf(tmp_path / "b.urdf")
    thing = ModelObject(f"{tmp_path}/b.urdf?scale=2")
    assert (thing.mass, *thing.bounds.size) == pytest.approx((0.1, 0.064, 0.064, 0.046))
    assert compiled(thing.mjcf_model).body_inertia[1] == pytest.approx([4e-5] * 3)
    with pytest.raises(ModelError, match="scale must be a positive number"):
        load_model(f"{tmp_path}/b.urdf?scale=0")


@pytest.mark.parametrize("form", ["urdf", "xml"])
def test_scaled_inertias_with_products_have_moments_scaled_by_the_square(tmp_path, form):
    (tmp_path / f"b.{form}").write_text(PENDULUM[form].format(2e-3, 3e-3, 4e-3, 1e-3, 5e-4, 0))
    moments = np.linalg.eigvalsh([[2e-3, 1e-3, 5e-4], [1e-3, 3e-3, 0], [5e-4, 0, 4e-3]])
    thing = ModelObject(f"{tmp_path}/b.{form}?scale=3")
    assert sorted(compiled(thing.mjcf_model).body_inertia[-1]) == pytest.approx(9 * moments)
    assert compiled(thing.mjcf_model).body_mass[-1] == pytest.approx(0.6)


PLATE = '<geom type="box" size=".02 .03 .025"{}/>'


def write_model(path, body, head="", attributes="") -> str:
    path.write_text(
        f'<mujoco>{head}<worldbody><body name="b" {attributes}>{body}</body></worldbody></mujoco>'
    )
    return str(path)


def beside_another(model: ModelObject) -> tuple[mujoco.MjModel, mujoco.MjModel]:
    """Compile a model attached to a world beside a light body, and the light body alone."""
    world = mjcf.RootElement()
    light = world.worldbody.add("body", name="light")
    light.add("geom", type="box", size=(0.01, 0.01, 0.01), mass=0.01)
    alone = compiled(world)
    world.attach(model.mjcf_model)
    return compiled(world), alone


@pytest.mark.parametrize(("settings", "geoms"), [
    ('boundmass="0.3" boundinertia="0.01"', PLATE.format(' mass="0.1"')),
    ('settotalmass="0.3"', PLATE.format("")),
    ('inertiafromgeom="true"',
     '<inertial mass="5" pos="0 0 0" diaginertia="1 1 1"/>' + PLATE.format(' mass="0.3"')),
    ('inertiagrouprange="3 3"',
     PLATE.format(' mass="0.3" group="3"') + PLATE.format(' mass="0.5" group="1"')),
])  # fmt: skip
@pytest.mark.parametrize("angle", ["radian", "degree"])
def test_settings_of_masses_hold_for_their_model_only(tmp_path, settings, geoms, angle):
    head = f'<compiler angle="{angle}" {settings}/>'
    model = ModelObject(model=write_model(tmp_path / "m.xml", geoms, head))
    both, alone = beside_another(model)
    assert model.mass == pytest.approx(0.3)
    assert both.body_mass.sum() == pytest.approx(0.31)
    assert both.body("light").inertia == pytest.approx(alone.body("light").inertia)


@pytest.mark.parametrize(("geom", "attributes"), [
    (PLATE.format(""), 'childclass="heavy"'),
    (PLATE.format(' class="heavy"'), ""),
    (PLATE.format(' class="main"'), 'childclass="heavy"'),
    (PLATE.format(""), ""),
])  # fmt: skip
def test_masses_of_default_classes_are_those_of_the_maker_and_can_be_changed(
    tmp_path, geom, attributes
):
    head = (
        '<compiler angle="radian"/><default><geom mass="0.2"/><default class="heavy">'
        '<geom mass="0.4"/></default></default>'
    )
    path = write_model(tmp_path / "m.xml", geom, head, attributes)
    expected = mujoco.MjModel.from_xml_path(path).body_mass.sum()
    model = ModelObject(model=path)
    assert model.mass == pytest.approx(expected)
    assert not model.warnings
    assert compiled(ModelObject(model=path, mass=0.3).mjcf_model).body_mass.sum() == pytest.approx(
        0.3
    )


def test_a_mocap_body_is_an_object_as_any_other(tmp_path):
    path = write_model(tmp_path / "m.xml", PLATE.format(' mass="0.1"'), attributes='mocap="true"')
    both, _ = beside_another(ModelObject(model=path))
    assert both.nmocap == 0


def test_soft_bodies_are_refused(tmp_path):
    flex = '<flexcomp name="f" type="grid" count="3 3 1" spacing=".02 .02 .02" dim="2" mass=".1"/>'
    with pytest.raises(BtManipError, match="soft bodies"):
        ModelObject(model=write_model(tmp_path / "m.xml", flex))


@pytest.mark.parametrize(("body", "rest", "words"), [
    ("<freejoint/>" + PLATE.format(' mass="0.1"'),
     '<body pos="0.2 0 0"><freejoint/><geom size="0.02" mass="0.1"/></body>', "2 free bodies"),
    ('<freejoint/><inertial mass="0.1" pos="0 0 0" diaginertia="1e-4 1e-4 1e-4"/>', "",
     "nothing of it collides"),
])  # fmt: skip
def test_what_an_object_cannot_do_is_a_warning(tmp_path, body, rest, words):
    path = tmp_path / "m.xml"
    path.write_text(f"<mujoco><worldbody><body>{body}</body>{rest}</worldbody></mujoco>")
    assert words in " ".join(ModelObject(model=str(path)).warnings)


def test_a_floating_joint_of_urdf_makes_an_object_free(tmp_path):
    floating = (
        '<link name="world"/><joint name="j" type="floating"><parent link="world"/>'
        '<child link="b"/></joint>'
    )
    model = ModelObject(write_urdf(tmp_path / "m.urdf", more=floating))
    assert model.free
    assert model.mass == pytest.approx(0.1)


def test_prefixes_without_a_namespace_are_read_and_hide_no_other_error(tmp_path):
    path = tmp_path / "m.urdf"
    text = f'<robot name="m">{BODY.format("2e-5", "", BOX)}<gazebo:old a:b="1">{{}}</robot>'
    path.write_text(text.format("</gazebo:old>"))
    assert ModelObject(model=str(path)).mass == pytest.approx(0.1)
    path.write_text(text.format(""))
    with pytest.raises(ModelError, match="tag mismatch"):
        ModelObject(model=str(path))
    path.write_text(text.format("</gazebo:old>").replace("gazebo:old", "xacro:if"))
    with pytest.raises(ModelError, match="this is xacro"):
        ModelObject(model=str(path))
    path.write_text("<!DOCTYPE robot>" + text.format("</gazebo:old>"))
    with pytest.raises(ModelError, match="DOCTYPE"):
        ModelObject(model=str(path))
