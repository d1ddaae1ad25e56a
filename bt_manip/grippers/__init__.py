"""Kinds of grippers: each is a `bt_manip.robots.Gripper` in its own package."""

from bt_manip import lazy_exports

from .solids import BodySurface as BodySurface
from .solids import Polyhedron as Polyhedron
from .solids import Solid as Solid
from .solids import collision_geoms_of as collision_geoms_of
from .solids import contact_friction as contact_friction
from .solids import solids_of as solids_of
from .two_finger import GRIP_DEPTH as GRIP_DEPTH
from .two_finger import FingerTravel as FingerTravel
from .two_finger import TwoFingerGripper as TwoFingerGripper
from .two_finger import TwoFingerParameters as TwoFingerParameters
from .two_finger import travel_digests as travel_digests
from .two_finger import two_finger_gripper as two_finger_gripper

__getattr__ = lazy_exports(__name__)  # names the package of what has moved
