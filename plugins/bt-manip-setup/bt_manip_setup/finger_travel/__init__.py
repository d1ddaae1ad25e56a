"""Fingers of grippers: found in a model, and measured for a robot's description."""

Each name is imported on first use.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip_setup.finger_travel.measurement import measured as measured
    from bt_manip_setup.finger_travel.search import FoundFingers as FoundFingers
    from bt_manip_setup.finger_travel.search import OverlappingHullsError as OverlappingHullsError
    from bt_manip_setup.finger_travel.search import find_fingers as find_fingers
    from bt_manip_setup.finger_travel.travel_file import TRAVEL_NOTE as TRAVEL_NOTE
    from bt_manip_setup.finger_travel.travel_file import write_travel as write_travel

__getattr__ = lazy_exports(__name__)
