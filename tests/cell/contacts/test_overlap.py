"""The deepest overlap of an entity, by distances of spheres."""

import mujoco
import pytest

from bt_manip.cell.contacts.overlap import deepest_overlap
from bt_manip.cell.naming import BodyNames

SPHERES = """<mujoco><worldbody><geom type="plane" size="1 1 1" pos="9 9 {floor}"/>
  <body name="free" pos="1 {free} 0"><freejoint/><geom size=".05"/></body>
  <body name="it" pos="1 0 0"><geom size=".1"/><geom size=".04" pos="0 .3 0"/></body>
  <body name="fixed" pos="{fixed} 0 0"><geom size=".12" contype="0"/></body>
  <body name="ghost" pos="1 0 0"><geom size=".1" contype="2" conaffinity="2"/></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("floor", "fixed", "free", "expected"),
    [
        (-1.0, 1.25, 0.6, None),
        (-1.0, 1.19, 0.38, ("fixed", 0.03)),
        (-1.0, 1.21, 0.37, ("free", 0.02)),
        (-0.06, 1.19, 0.37, ("world", 0.04)),
        (-0.09, 0.81, 0.37, ("fixed", 0.03)),
    ],
)
def test_the_deepest_overlap_with_what_can_touch_it_is_found(floor, fixed, free, expected):
    model = mujoco.MjModel.from_xml_string(SPHERES.format(floor=floor, fixed=fixed, free=free))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found = deepest_overlap(model, data, BodyNames(model), "it")
    assert found == (expected and ("it", expected[0], pytest.approx(expected[1])))
