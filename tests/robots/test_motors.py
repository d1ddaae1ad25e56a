"""The effort of a joint or tendon is bounded by the tightest limit of model and actuators."""

import mujoco
import numpy as np
import pytest

from bt_manip.robots.motors import effort_limit

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
