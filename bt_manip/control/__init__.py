"""Torque controllers of arms."""

from .computed_torque import ComputedTorque as ComputedTorque
from .controller import Controller as Controller
from .controller_manager import ControllerManager as ControllerManager
from .exceptions import ControlError as ControlError
from .gravity_compensated_pd import GravityCompensatedPD as GravityCompensatedPD
from .measured_arm import MeasuredArm as MeasuredArm
from .native_pd import FEEDFORWARD_STEPS as FEEDFORWARD_STEPS
from .native_pd import NativePD as NativePD
from .pd_law import gain_array as gain_array
from .reference import Hold as Hold
from .reference import Reference as Reference
