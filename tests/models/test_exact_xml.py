"""Models are written with all digits, frames composed, as MuJoCo reads them."""

import mujoco
import pytest

from bt_manip.cell.objects import mjcf_root
from bt_manip.models import exact_xml, load_model
from bt_manip.models.exact_xml import repair
from bt_manip.robots import read_model
from tests.support.models import compiled

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


@pytest.fixture
def path(tmp_path):
    """Give the path of a model of frames, replicas and an attached model."""
    (tmp_path / "part.xml").write_text(PART)
    (tmp_path / "all.xml").write_text(FRAMES)
    return str(tmp_path / "all.xml")


@pytest.mark.parametrize("kind", ["object", "robot"])
def test_frames_replicas_and_attached_models_are_read_as_mujoco_reads_them(path, kind):
    expected = mujoco.MjModel.from_xml_path(path)
    root = read_model(path, "robot")[0] if kind == "robot" else mjcf_root(load_model(path))
    model = compiled(root)
    for name in SAME:
        assert getattr(model, name) == pytest.approx(getattr(expected, name), abs=1e-6), name


def test_scaled_models_have_scaled_poses(path):
    poses = []
    for scale, end in ((1, ""), (2, "?scale=2")):
        model = compiled(mjcf_root(load_model(path + end)))
        data = mujoco.MjData(model)
        data.joint("s").qpos = 0.01 * scale
        mujoco.mj_forward(model, data)
        poses.append(data.geom_xpos.copy())
    assert poses[1] == pytest.approx(2 * poses[0], abs=1e-6)
    assert model.joint("s").range == pytest.approx([0, 0.2])


DIGITS = """<mujoco><worldbody><geom size=".1111111111"/>
<body name="a" pos=".1234567891 .2 .3" quat=".8 .1 .2 .3">
  <joint axis=".1 .2 .9" pos=".0123456789 0 0" range="-12.3456789 45.6789123"/>
  <joint type="slide" axis=".3 .2 .1" range=".0012345678 .1"/>
  <geom size=".1234567891" pos=".2345678912 0 0"/>
  <geom type="box" size=".1 .2 .3456789123" quat=".8 .1 .2 .3"/>
  <body name="b" pos="0 0 .3456789123"><inertial pos=".0123456789 0 0" quat=".7 .1 .2 .5"
    mass=".1234567891" diaginertia=".0123456789 .0234567891 .0345678912"/>
    <joint axis=".5 .2 .7" range="-1.23456789 4.56789123"/>
    <joint axis=".3 .9 .1" pos="0 .0123456789 0"/>
    <geom size=".2345678912"/><geom type="capsule" size=".0345678912 .1" pos="0 0 .456789123"/>
  </body></body></worldbody></mujoco>"""


def test_each_number_of_a_body_is_written_with_all_its_digits():
    spec = mujoco.MjSpec.from_string(DIGITS)
    model, found = spec.compile(), mujoco.MjModel.from_xml_string(exact_xml(spec))
    for name in (*SAME, "body_iquat"):
        assert getattr(found, name) == pytest.approx(getattr(model, name), abs=1e-12), name


@pytest.mark.parametrize(
    ("moments", "kept"), [((1, 1, 1.99), True), ((1, 1, 2.01), False), ((0, 0, 0), False)]
)
def test_moments_above_the_sum_of_the_others_are_made_ones_that_mujoco_takes(moments, kept):
    spec = mujoco.MjSpec.from_string(
        f"""<mujoco><worldbody><body><geom size=".1"/><inertial mass="1" pos="0 0 0"
        diaginertia="{" ".join(map(str, moments))}"/></body></worldbody></mujoco>"""
    )
    assert repair(spec) is not kept
    largest = max(moments)
    repaired = [largest, largest, 0.0]
    found = spec.compile().body_inertia[1]
    assert sorted(found) == pytest.approx(sorted(moments if kept else repaired), abs=1e-13)
