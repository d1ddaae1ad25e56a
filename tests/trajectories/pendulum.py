"""A pendulum whose times can be computed by hand."""

import mujoco
import numpy as np

from bt_manip.robots import MotionLimits, RobotModel, Tolerance

PENDULUM = """
<mujoco>
  <option gravity="0 0 {gravity}"/>
  <worldbody>
    <body>
      <joint name="j" axis="0 1 0" damping="{damping}"/>
      <inertial pos="1 0 0" mass="2" diaginertia="1e-9 1e-9 1e-9"/>
      <site name="tip" pos="1 0 0"/>
    </body>
  </worldbody>
</mujoco>
"""


def pendulum(gravity=0.0, effort=10.0, acceleration=100.0, velocity=100.0, damping=0.0, jerk=1e5):
    """Return a point mass of 2 kg on a bar of 1 m."""
    one = np.ones(1)
    model = mujoco.MjModel.from_xml_string(PENDULUM.format(gravity=gravity, damping=damping))
    return RobotModel(
        model,
        joints=["j"],
        tool_frame="tip",
        limits=MotionLimits(
            -10 * one, 10 * one, velocity * one, acceleration * one, jerk * one, effort * one
        ),
        home=[0.0],
        tolerance=Tolerance(),
        qpos=model.qpos0,
    )
