"""Compliant controllers, and tasks for them: pressing a button, inserting a peg."""

from bt_manip_impedance.cartesian_impedance import CartesianImpedance as CartesianImpedance
from bt_manip_impedance.insert import Insert as Insert
from bt_manip_impedance.insert import IsInserted as IsInserted
from bt_manip_impedance.joint_impedance import JointImpedance as JointImpedance
from bt_manip_impedance.press import IsReleased as IsReleased
from bt_manip_impedance.press import Press as Press
from bt_manip_impedance.push_button import PushButton as PushButton
