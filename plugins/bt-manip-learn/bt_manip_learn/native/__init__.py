"""Control of arms and grippers by MuJoCo's actuators, for batches of environments."""

from .controller import FEEDFORWARD_STEPS as FEEDFORWARD_STEPS
from .controller import NativePD as NativePD
from .gripper import NativeTwoFingerGripper as NativeTwoFingerGripper
