"""Joints have one motor each; the tightest limit of model and actuators bounds an effort."""

import mujoco
import numpy as np
import pytest
from dm_control import mjcf

from bt_manip.robots.motors import effort_limit, ensure_motors

MODEL = """<mujoco><worldbody><body><joint name="a" {joint}/><geom size="0.1"/></body></worldbody>
<tendon><fixed name="t"><joint joint="a" coef="1"/></fixed></tendon>
<actuator>{actuators}</actuator></mujoco>"""


@pytest.mark.parametrize(
    ("joint", "actuators", "limit"),
    [
        ("", '<motor joint="a"/>', np.inf),
        ("", '<motor joint="a" gear="-3" ctrlrange="-7 5"/>', 15.0),
        ("", '<motor joint="a" gear="3" ctrlrange="-7 8" forcerange="-4 6"/>', 12.0),
        ('actuatorfrcrange="-9 11"', '<motor joint="a" gear="3" ctrlrange="-7 5"/>', 9.0),
        ("", '<position joint="a" gear="2" ctrlrange="-1 1" forcerange="-20 30"/>', 40.0),
        ("", '<general joint="a" gainprm="2" ctrlrange="-1 1"/>', np.inf),
        ("", '<motor joint="a" ctrlrange="-8 8"/><motor joint="a" ctrlrange="-5 5"/>', 5.0),
        ("", '<motor tendon="t" gear="2" ctrlrange="-1 1"/>', np.inf),
    ],
)
def test_the_limit_of_a_joint_is_the_least_force_times_gear_of_one_side(joint, actuators, limit):
    model = mujoco.MjModel.from_xml_string(MODEL.format(joint=joint, actuators=actuators))
    assert effort_limit(model, 0) == limit
    assert effort_limit(model, 0, "tendon") == (2.0 if "tendon=" in actuators else np.inf)


THREE = """<mujoco><worldbody><body><joint name="a"/><geom size="0.1"/>
<body><joint name="b"/><geom size="0.1"/><body><joint name="c"/><geom size="0.1"/>
</body></body></body></worldbody>
<tendon>
  <fixed name="ab"><joint joint="a" coef="1"/><joint joint="b" coef="1"/></fixed>
  <fixed name="ac"><joint joint="a" coef="1"/><joint joint="c" coef="1"/></fixed>
</tendon>
<actuator>
  <position name="servo" joint="a"/><motor name="plain" joint="a"/><motor name="more" joint="a"/>
  <motor name="geared" joint="b" gear="2"/><motor name="other" joint="c"/>
  <motor name="both" tendon="ab"/><motor name="partly" tendon="ac"/>
</actuator></mujoco>"""


def test_joints_keep_a_plain_motor_or_get_one_and_lose_all_that_moves_them_alone():
    root = mjcf.from_xml_string(THREE)
    alone = mujoco.MjModel.from_xml_string(THREE)
    driven = [root.find("joint", name) for name in "ab"]
    motors = ensure_motors(root, alone, driven, [5.0, 7.0])
    assert [motor.name for motor in motors] == ["plain", "b_motor"]
    left = {actuator.name for actuator in root.find_all("actuator")}
    assert left == {"plain", "b_motor", "other", "partly"}
    model = mujoco.MjModel.from_xml_string(root.to_xml_string())
    assert [effort_limit(model, joint) for joint in range(3)] == [5.0, 7.0, np.inf]
