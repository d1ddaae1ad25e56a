"""Things that stand in a cell."""

from bt_manip.cell.objects.basket import Basket as Basket
from bt_manip.cell.objects.catalogue import Catalogue as Catalogue
from bt_manip.cell.objects.cube import Cube as Cube
from bt_manip.cell.objects.model_object import ModelObject as ModelObject
from bt_manip.cell.objects.prop import Prop as Prop
from bt_manip.cell.objects.table import Table as Table
