"""The cell: a composer arena, its objects, its compiled physics and its contacts."""

from .rest import MAX_REST_SPEED as MAX_REST_SPEED
from .rest import MAX_REST_TURNING as MAX_REST_TURNING
from .rest import at_rest as at_rest

from .arena import Arena as Arena
from .cell import Cell as Cell
from .contacts.contact_monitor import ContactMonitor as ContactMonitor
from .contacts.contact_monitor import ContactSummary as ContactSummary
from .contacts.contact_monitor import MonitoredEntity as MonitoredEntity
from .contacts.contacts import ContactEvent as ContactEvent
from .contacts.contacts import ContactForce as ContactForce
from .contacts.contacts import Contacts as Contacts
from .contacts.contacts import Wrench as Wrench
from .exceptions import CellError as CellError
from .exceptions import OverlapError as OverlapError
from .exceptions import PhysicsDiverged as PhysicsDiverged
from .naming import BodyNames as BodyNames
from .naming import entity_of as entity_of
from .naming import unique_name as unique_name
from .objects import Basket as Basket
from .objects import Camera as Camera
from .objects import CellObject as CellObject
from .objects import Cube as Cube
from .objects import Prop as Prop
from .objects import Segmentation as Segmentation
from .objects import Table as Table
from .objects import as_object as as_object
from .objects import bottom_of as bottom_of
from .objects import looking_at as looking_at
from .physics.state import integration_state as integration_state
from .region import Region as Region
