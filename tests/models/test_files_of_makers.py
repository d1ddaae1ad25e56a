"""Models as their makers wrote them: read as MuJoCo reads them, or refused with the remedy."""

import re

import mujoco
import pytest

from bt_manip.cell.objects import ModelObject, mjcf_root
from bt_manip.exceptions import BtManipError
from bt_manip.models import ModelError, load_model
from bt_manip.robots import read_model

BODY = """<link name="b"><inertial><mass value="0.1"/><inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0"
 ixz="0" iyz="0"/></inertial>{1}<collision><geometry>{2}</geometry></collision></link>"""
BOX = '<box size="0.032 0.032 0.023"/>'
LOST = '<visual><geometry><mesh filename="gone.dae"/></geometry></visual>'
PART = """<mujoco model="part"><default><default class="red"><geom friction="0.4"/></default>
</default><asset><mesh name="wedge" vertex="0 0 0 .1 0 0 0 .1 0 0 0 .1"/></asset><worldbody>
<body name="p" pos="0.1 0 0"><joint name="j" axis="0 1 0" range="-50 60"/>
<geom class="red" type="box" size=".01 .02 .03"/><geom type="mesh" mesh="wedge"/></body></worldbody>
</mujoco>"""
FRAMES = """<mujoco model="all"><compiler eulerseq="XYZ"/><default><default class="soft">
<geom friction="0.3"/><joint damping="0.7"/></default></default>
<asset><model name="part" file="part.xml"/></asset><worldbody><body name="b" pos="0 0 1">
<geom type="sphere" size=".01"/><frame pos="0.123456789 0 0.025" euler="0 30 90" childclass="soft">
<geom type="box" size=".02 .03 .025" mass=".1" euler="10 20 30" pos="0.01 0.02 0.03"/>
<frame pos="0 0 0.1" euler="45 0 0"><geom type="capsule" fromto="0 0 0 0.1 0.1 0" size="0.01"/>
<body name="in" pos="0.05 0 0"><joint name="h" axis="1 0 0" pos="0.01 0 0"/><geom size=".01"/>
</body></frame></frame>
<body name="d" pos="0.3 0 0"><frame pos="0.02 0 0" euler="0 0 60"><joint name="s" type="slide"
axis="1 0 0" range="0 0.1"/><geom size=".02"/></frame></body>
<replicate count="3" offset="0 0 0.1" euler="0 0 20"><geom type="box" size=".01 .02 .01"/>
</replicate>
<frame pos="0 0.2 0" euler="0 90 0"><attach model="part" body="p" prefix="left_"/></frame></body>
</worldbody></mujoco>"""
SAME = (
    "body_mass", "body_inertia", "body_pos", "body_quat", "body_ipos", "geom_pos", "geom_quat",
    "geom_size", "geom_friction", "jnt_pos", "jnt_axis", "jnt_range", "dof_damping",
)  # fmt: skip


def compiled(root) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(root.to_xml_string(), root.get_assets())


def write_groups(path, *boxes) -> None:
    """Write boxes as the groups of an OBJ file, each with its centre and size [m]."""
    import trimesh

    lines, count = [], 0
    for i, (centre, size) in enumerate(boxes):
        box = trimesh.creation.box(size).apply_translation(centre)
        lines += [f"o part_{i}", *(f"v {x} {y} {z}" for x, y, z in box.vertices)]
        lines += [f"f {a} {b} {c}" for a, b, c in box.faces + 1 + count]
        count += len(box.vertices)
    path.write_text("\n".join(lines))


@pytest.mark.parametrize("kind", ["object", "robot"])
def test_frames_replicas_and_attached_models_are_read_as_mujoco_reads_them(tmp_path, kind):
    (tmp_path / "part.xml").write_text(PART)
    (tmp_path / "all.xml").write_text(FRAMES)
    expected = mujoco.MjModel.from_xml_path(str(tmp_path / "all.xml"))
    if kind == "robot":
        model = compiled(read_model(str(tmp_path / "all.xml"), "robot")[0])
    else:
        model = compiled(mjcf_root(load_model(str(tmp_path / "all.xml"))))
    for name in SAME:
        assert getattr(model, name) == pytest.approx(getattr(expected, name), abs=1e-6), name


@pytest.mark.parametrize("head", [
    '<?xml version="0.0" ?>\n', "<?xml version='2.7' encoding='ISO-8859-1'?>",
    "\n\n<?xml version='1.0'?>",
])  # fmt: skip
def test_any_version_of_xml_is_read(tmp_path, head):
    """MuJoCo, Pinocchio and PyBullet ignore the declaration."""
    (tmp_path / "a.urdf").write_text(f'{head}<robot name="r">{BODY.format(1e-5, "", BOX)}</robot>')
    (tmp_path / "a.xml").write_text(
        f"{head}<mujoco><worldbody><geom size='1'/></worldbody></mujoco>"
    )
    assert ModelObject(str(tmp_path / "a.urdf")).mass == pytest.approx(0.1)
    assert ModelObject(str(tmp_path / "a.xml")).bounds.size == pytest.approx([2, 2, 2])


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
    urdf.write_text(f'<robot name="r">{BODY.format(1e-5, LOST, BOX)}</robot>')
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
    """As PyBullet reads them."""
    walls = [((x, 0, 0.06), (0.02, 0.1, 0.1)) for x in (-0.14, 0.14)]
    write_groups(tmp_path / "u_vhacd.obj", ((0, 0, 0), (0.3, 0.1, 0.02)), *walls)
    mesh = '<mesh filename="u_vhacd.obj"/>'
    (tmp_path / "u.urdf").write_text(f'<robot name="r">{BODY.format(1e-4, "", mesh)}</robot>')
    for name in ("u.urdf", "u_vhacd.obj"):
        thing = ModelObject(str(tmp_path / name))
        assert len(thing.collision_geoms) == 3
        assert thing.bounds.size == pytest.approx([0.3, 0.1, 0.12], abs=1e-6)
    volume = 0.3 * 0.1 * 0.02 + 2 * 0.02 * 0.1 * 0.1
    assert thing.mass == pytest.approx(1000 * volume)


@pytest.mark.parametrize(("inertia", "used", "words"), [
    (1.0, 0.1 / 12 * 2 * 0.032**2, "is impossible for 0.1 kg within 0.0254 m"),
    (0.0, 0.1 / 12 * 2 * 0.032**2, "is impossible"),
    (5e-5, 0.1 / 12 * 2 * 0.032**2, "is impossible"),  # below m r^2, but of 16 mm along each axis
    (1e-8, 1e-8, "below a hundredth of its geometry's, 1.71e-05"),
    (1e-5, 1e-5, ""),
])  # fmt: skip
def test_an_impossible_inertia_is_replaced_by_that_of_a_uniform_box(tmp_path, inertia, used, words):
    path = tmp_path / "brick.urdf"
    path.write_text(f'<robot name="r">{BODY.format(inertia, "", BOX)}</robot>')
    thing = ModelObject(str(path))
    assert compiled(thing.mjcf_model).body_inertia[1].max() == pytest.approx(used)
    assert words in "".join(thing.warnings) and bool(thing.warnings) == bool(words)


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
    (1, 1, 0, 0, 0, 0), (1e-3, 1e-3, 1e-3, 2e-3, 0, 0), (0, 0, 0, 0, 0, 0), (1e-3, 0, 0, 0, 0, 0),
])  # fmt: skip
def test_an_inertia_without_positive_eigenvalues_is_replaced(tmp_path, kind, form, values):
    """MuJoCo refuses it; the moments of a uniform box are m (b^2 + c^2) / 12."""
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
    for thing in (
        ModelObject(f"{tmp_path}/mm.obj?scale=0.001"),
        ModelObject(f"{tmp_path}/mm.obj", scale=0.001),
    ):
        assert thing.bounds.size == pytest.approx([0.04, 0.06, 0.05])
        assert thing.mass == pytest.approx(0.12) and thing.free
        assert "the file gives no mass" in thing.warnings[0]
    assert not ModelObject(f"{tmp_path}/mm.obj", scale=0.001, mass=0.2).warnings
    (tmp_path / "b.urdf").write_text(f'<robot name="r">{BODY.format(1e-5, "", BOX)}</robot>')
    thing = ModelObject(f"{tmp_path}/b.urdf?scale=2")
    assert (thing.mass, *thing.bounds.size) == pytest.approx((0.1, 0.064, 0.064, 0.046))
    assert compiled(thing.mjcf_model).body_inertia[1] == pytest.approx([4e-5] * 3)
    with pytest.raises(ModelError, match="scale must be a positive number"):
        load_model(f"{tmp_path}/b.urdf?scale=0")


def test_scaled_models_have_scaled_poses(tmp_path):
    (tmp_path / "part.xml").write_text(PART)
    (tmp_path / "all.xml").write_text(FRAMES)
    plain, double = (mjcf_root(load_model(f"{tmp_path}/all.xml{end}")) for end in ("", "?scale=2"))
    models = [compiled(root) for root in (plain, double)]
    poses = []
    for model in models:
        data = mujoco.MjData(model)
        data.joint("s").qpos = 0.01 * (1 + len(poses))
        mujoco.mj_forward(model, data)
        poses.append(data.geom_xpos.copy())
    assert poses[1] == pytest.approx(2 * poses[0], abs=1e-6)
    assert models[1].joint("s").range == pytest.approx([0, 0.2])


def test_a_message_names_the_element_that_mujoco_names(tmp_path):
    (tmp_path / "a.urdf").write_text(
        f'<robot name="r">{BODY.format("1e-5x", "", BOX)}</robot>'.replace("\n", "")
    )
    with pytest.raises(ModelError, match="Element 'inertia', line 1"):
        load_model(str(tmp_path / "a.urdf"))
