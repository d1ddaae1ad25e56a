"""Which joints of a gripper move together."""

import mujoco
import pytest

from bt_manip_setup.finger_travel.bench import FingerBench

MODEL = """<mujoco><compiler autolimits="true"/><worldbody><body name="palm"><joint name="turn"/>
  <geom size="0.01"/>
  <body name="A"><joint name="a"/><geom size="0.01"/><site name="of_a"/>
    <body name="B"><joint name="b"/><geom size="0.01"/><site name="of_b"/></body></body>
  <body name="C"><joint name="c" type="slide"/><geom size="0.01"/><site name="of_c"/></body>
</body></worldbody><tendon>
  <fixed name="x"><joint joint="a" coef="1"/></fixed>
  <fixed name="y" {}><joint joint="b" coef="1"/><joint joint="c" coef="1"/></fixed>
</tendon><equality>{}</equality></mujoco>"""


@pytest.mark.parametrize(
    ("equality", "coupled"),
    [
        ("", "a"),
        ('<joint joint1="a" joint2="c"/>', "ac"),
        ('<joint joint1="c" joint2="a"/>', "ac"),
        ('<joint joint1="a" joint2="c" active="false"/>', "a"),
        ('<joint joint1="a" joint2="b"/><joint joint1="c" joint2="b"/>', "abc"),
        ('<connect body1="B" body2="C" anchor="0 0 0"/>', "abc"),  # a closed loop
        ('<connect site1="of_b" site2="of_c"/>', "abc"),
        ('<weld body1="A" body2="C"/>', "ac"),
        ('<weld site1="of_b" site2="of_a"/>', "a"),
        ('<tendon tendon1="x" tendon2="y"/>', "abc"),
        ('<tendon tendon1="y"/>', "a"),
    ],
)
def test_joints_are_coupled_by_equalities_and_closed_loops(equality, coupled):
    model = mujoco.MjModel.from_xml_string(MODEL.format("", equality))
    bench = FingerBench(model, ["turn"])
    found = bench.coupled(model.joint("a").id)
    assert sorted(model.joint(j).name for j in found) == [*coupled]


@pytest.mark.parametrize(("width", "coupled"), [(9e-5, "bc"), (1.1e-4, "b")])
def test_joints_are_coupled_by_a_tendon_whose_length_hardly_changes(width, coupled):
    model = mujoco.MjModel.from_xml_string(MODEL.format(f'range="0.1 {0.1 + width}"', ""))
    found = FingerBench(model, ["turn"]).coupled(model.joint("b").id)
    assert sorted(model.joint(j).name for j in found) == [*coupled]
