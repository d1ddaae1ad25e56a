"""Controllers: what turns a reference into torque, and a grip into forces."""

from bt_manip.control.computed_torque import ComputedTorque as ComputedTorque
from bt_manip.control.controller import Controller as Controller
from bt_manip.control.exceptions import ControlError as ControlError
from bt_manip.control.exceptions import ControllerFault as ControllerFault
from bt_manip.control.gravity_compensated_pd import GravityCompensatedPD as GravityCompensatedPD
from bt_manip.control.gripper_controller import GripperController as GripperController
from bt_manip.control.reference import Hold as Hold
from bt_manip.control.reference import Reference as Reference
