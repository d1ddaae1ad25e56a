"""Compliant controllers, and tasks for them: a button, a peg, a drawer and a hand-over."""

from bt_manip_impedance.cartesian_impedance import CartesianImpedance as CartesianImpedance
from bt_manip_impedance.drawer import Drawer as Drawer
from bt_manip_impedance.hand_over import FindFreeEnd as FindFreeEnd
from bt_manip_impedance.hand_over import HoldOut as HoldOut
from bt_manip_impedance.hand_over import IsHandedOver as IsHandedOver
from bt_manip_impedance.insert import Insert as Insert
from bt_manip_impedance.insert import IsInserted as IsInserted
from bt_manip_impedance.joint_impedance import JointImpedance as JointImpedance
from bt_manip_impedance.open_drawer import IsOpen as IsOpen
from bt_manip_impedance.open_drawer import PullOpen as PullOpen
from bt_manip_impedance.open_drawer import ReachHandle as ReachHandle
from bt_manip_impedance.peg_and_board import HoleBoard as HoleBoard
from bt_manip_impedance.peg_and_board import Peg as Peg
from bt_manip_impedance.press import IsReleased as IsReleased
from bt_manip_impedance.press import Press as Press
from bt_manip_impedance.press import WasPressed as WasPressed
from bt_manip_impedance.push_button import PushButton as PushButton
