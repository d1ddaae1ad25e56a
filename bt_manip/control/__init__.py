"""Torque controllers of arms."""

from bt_manip import lazy_exports

from .computed_torque import ComputedTorque as ComputedTorque
from .controller import Controller as Controller
from .controller_manager import ControllerManager as ControllerManager
from .exceptions import ControlError as ControlError
from .gravity_compensated_pd import GravityCompensatedPD as GravityCompensatedPD
from .measured_arm import MeasuredArm as MeasuredArm
from .pd_law import default_gains as default_gains
from .pd_law import gain_array as gain_array
from .reference import Hold as Hold
from .reference import Reference as Reference

__getattr__ = lazy_exports(__name__)  # names the package of what has moved
