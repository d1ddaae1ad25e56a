"""Fingers of grippers: found in a model, and measured for a robot's description."""

from .measurement import measured as measured
from .search import FoundFingers as FoundFingers
from .search import OverlappingHullsError as OverlappingHullsError
from .search import find_fingers as find_fingers
from .travel_file import TRAVEL_NOTE as TRAVEL_NOTE
from .travel_file import write_travel as write_travel
