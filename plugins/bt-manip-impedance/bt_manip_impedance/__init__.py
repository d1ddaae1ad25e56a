"""A compliant arm, and a button for it to press."""

from bt_manip_impedance.joint_impedance import JointImpedance as JointImpedance
from bt_manip_impedance.push_button import PushButton as PushButton
