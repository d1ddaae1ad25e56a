"""The cell: a composer arena, its objects, its compiled physics and its contacts."""

from bt_manip.cell.arena import Arena as Arena
from bt_manip.cell.cell import Cell as Cell
from bt_manip.cell.contacts.contact_events import ContactEvent as ContactEvent
from bt_manip.cell.contacts.contact_monitor import ContactMonitor as ContactMonitor
from bt_manip.cell.contacts.contact_monitor import ContactSummary as ContactSummary
from bt_manip.cell.contacts.contacts import ContactForce as ContactForce
from bt_manip.cell.contacts.contacts import Contacts as Contacts
from bt_manip.cell.contacts.contacts import Wrench as Wrench
from bt_manip.cell.exceptions import CellError as CellError
from bt_manip.cell.exceptions import OverlapError as OverlapError
from bt_manip.cell.exceptions import PhysicsDiverged as PhysicsDiverged
from bt_manip.cell.naming import unique_name as unique_name
from bt_manip.cell.objects import Basket as Basket
from bt_manip.cell.objects import Cube as Cube
from bt_manip.cell.objects import Prop as Prop
from bt_manip.cell.objects import Table as Table
from bt_manip.cell.objects.camera import Camera as Camera
from bt_manip.cell.objects.camera import Segmentation as Segmentation
from bt_manip.cell.objects.camera import looking_at as looking_at
from bt_manip.cell.region import Region as Region

from .naming import BodyNames as BodyNames
from .naming import entity_of as entity_of
