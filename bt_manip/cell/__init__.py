"""The cell: a composer arena, its objects, its compiled physics and its contacts."""

from bt_manip import lazy_exports

from .arena import OVERVIEW as OVERVIEW
from .arena import Arena as Arena
from .cell import Cell as Cell
from .contacts.contact_monitor import NO_CONTACTS as NO_CONTACTS
from .contacts.contact_monitor import ContactSummary as ContactSummary
from .contacts.contact_monitor import MonitoredEntity as MonitoredEntity
from .contacts.contacts import ContactEvent as ContactEvent
from .contacts.contacts import ContactEventDetector as ContactEventDetector
from .contacts.contacts import Wrench as Wrench
from .exceptions import CellError as CellError
from .exceptions import OverlapError as OverlapError
from .exceptions import PhysicsDiverged as PhysicsDiverged
from .geometry import body_poses as body_poses
from .geometry import centre_of_mass as centre_of_mass
from .geometry import collision_geoms as collision_geoms
from .geometry import extent as extent
from .geometry import geom_boxes as geom_boxes
from .geometry import geom_pose as geom_pose
from .geometry import nearest_free as nearest_free
from .naming import WORLD as WORLD
from .naming import BodyNames as BodyNames
from .naming import entity_of as entity_of
from .naming import escaped_name as escaped_name
from .naming import literal_name as literal_name
from .naming import name_elements as name_elements
from .naming import short_name as short_name
from .naming import unique_name as unique_name
from .objects import Basket as Basket
from .objects import Camera as Camera
from .objects import CellObject as CellObject
from .objects import Cube as Cube
from .objects import ParametricEntity as ParametricEntity
from .objects import Table as Table
from .objects import as_object as as_object
from .objects import bottom_of as bottom_of
from .objects import looking_at as looking_at
from .physics.state import integration_state as integration_state
from .png import png as png
from .png import write_png as write_png
from .predicates import at_rest as at_rest
from .predicates import is_in as is_in
from .predicates import is_on as is_on
from .predicates import is_rest_velocity as is_rest_velocity
from .predicates import is_within as is_within
from .predicates import surrounds as surrounds
from .predicates import why_not_at_rest as why_not_at_rest
from .predicates import why_not_in as why_not_in
from .predicates import why_not_on as why_not_on
from .predicates import why_not_released as why_not_released
from .region import Region as Region
from .rendering import FrameRenderer as FrameRenderer
from .rendering import NoOpenGLError as NoOpenGLError
from .rendering import camera_number as camera_number
from .rendering import parse_size as parse_size
from .rendering import render as render

__getattr__ = lazy_exports(__name__)  # names the package of what has moved
