"""The arm: planning and following motions, external-force guard, several arms."""

from .arm import MARGIN as MARGIN
from .arm import Arm as Arm
from .coordination import MultiArmCoordinator as MultiArmCoordinator
from .external_force_guard import ExternalForceGuard as ExternalForceGuard
from .follower import SENT_AHEAD as SENT_AHEAD
