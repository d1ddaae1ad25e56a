"""URDF through MuJoCo's own reader, with nothing rounded and all meshes found."""

import mujoco
import numpy as np
import pytest

from bt_manip.models import ModelError, load_model

ARM = """<robot name="arm">
<link name="base"><inertial><mass value="3.141592653589793"/><inertia ixx="0.0123456789" iyy="0.02"
  izz="0.025" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
<link name="arm"><inertial><origin xyz="0 0 0.25"/><mass value="1.5"/><inertia ixx="0.03125"
  iyy="0.03125" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>{}</link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/>
  <origin xyz="0 0 0.123456789"/><axis xyz="0 1 0"/>
  <limit lower="-1.23456789" upper="0.5" effort="12" velocity="1"/><dynamics damping="0.1"/></joint>
</robot>"""


def compiled(address: str) -> mujoco.MjModel:
    made = load_model(address)
    return mujoco.MjModel.from_xml_string(made.xml, dict(made.assets))


def test_masses_joints_and_places_keep_all_their_digits(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(ARM.format(""))
    model = compiled(str(path))
    assert model.body("base").mass[0] == 3.141592653589793  # the base is a body too
    assert model.body("arm").mass[0] == 1.5
    assert np.sort(model.body("base").inertia) == pytest.approx([0.0123456789, 0.02, 0.025])
    assert model.body("arm").pos == pytest.approx([0, 0, 0.123456789], abs=1e-15)
    assert model.joint("elbow").range == pytest.approx([-1.23456789, 0.5], abs=1e-15)
    assert model.joint("elbow").axis == pytest.approx([0, 1, 0])
    assert model.jnt_actfrcrange[0] == pytest.approx([-12, 12])


@pytest.mark.parametrize(
    "name", ["package://my_arm/meshes/rod.stl", "meshes/../meshes/rod.stl", "file://meshes/rod.stl"]
)
def test_meshes_are_found_by_package_or_beside_the_file(tmp_path, name):
    import trimesh

    package = tmp_path / "my_arm"
    (package / "meshes").mkdir(parents=True)
    trimesh.creation.box((0.1, 0.1, 0.5)).export(package / "meshes" / "rod.stl")
    visual = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    if name.startswith("package"):
        path = package / "urdf" / "arm.urdf"
        path.parent.mkdir()
    else:
        path = package / "arm.urdf"
    path.write_text(ARM.format(visual))
    assert compiled(str(path)).nmesh == 1


def test_a_urdf_is_found_in_a_package_of_the_environment(tmp_path, monkeypatch):
    path = tmp_path / "share" / "my_arm" / "urdf" / "arm.urdf"
    path.parent.mkdir(parents=True)
    path.write_text(ARM.format(""))
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert compiled("package://my_arm/urdf/arm.urdf").njnt == 1
    with pytest.raises(ModelError, match="did you mean 'my_arm'"):
        load_model("package://my_amr/urdf/arm.urdf")
    with pytest.raises(ModelError, match="there is no 'urdf/leg.urdf' in the package"):
        load_model("package://my_arm/urdf/leg.urdf")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("<robot", "<!DOCTYPE robot><robot"), "DOCTYPE"),
        (("</robot>", ""), "not XML"),
        (('xyz="0 0 0.25"', 'xyz="0 NaN 0.25"'), r"arm.urdf:5: <origin>: xyz has NaN"),
        (('<link name="base">', '<link name="base"><visual><origin rpy="nan 0 0"/></visual>'),
         r"arm.urdf:2: <origin>: rpy has NaN"),
        (('ixx="0.0123456789"', 'ixx="1e-5x"'), "Element 'inertia', line 2"),
        (("type=\"revolute\"", "type=\"wobbly\""), "MuJoCo cannot read it"),
        (("</link>\n<joint", '<collision><geometry><mesh filename="no.stl"/></geometry></collision>'
          "</link>\n<joint"), r"arm\.urdf:\d+: there is no mesh 'no.stl'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_error_with_the_place(tmp_path, change, words):
    path = tmp_path / "arm.urdf"
    path.write_text(ARM.format("").replace(*change))
    with pytest.raises(ModelError, match=words):
        load_model(str(path))
