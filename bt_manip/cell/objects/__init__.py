"""Objects and cameras of a cell."""

from bt_manip import lazy_exports

from .bounds import geom_box as geom_box
from .bundled import Basket as Basket
from .bundled import Cube as Cube
from .bundled import Table as Table
from .camera import Camera as Camera
from .camera import looking_at as looking_at
from .catalogue import Catalogue as Catalogue
from .categories import check_spelling as check_spelling
from .cell_object import CellObject as CellObject
from .cell_object import DeclaredGrasp as DeclaredGrasp
from .cell_object import as_object as as_object
from .cell_object import bottom_of as bottom_of
from .model_object import ModelObject as ModelObject
from .model_object import mjcf_root as mjcf_root
from .plausibility import correct_inertias as correct_inertias
from .plausibility import invented_masses as invented_masses
from .primitive_prop import PrimitiveProp as PrimitiveProp
from .primitive_prop import length as length
from .primitives import Bin as Bin
from .primitives import Block as Block
from .primitives import BlueBlock as BlueBlock
from .primitives import Bottle as Bottle
from .primitives import Box as Box
from .primitives import Can as Can
from .primitives import Capsule as Capsule
from .primitives import ConvexMesh as ConvexMesh
from .primitives import Cylinder as Cylinder
from .primitives import GreenBlock as GreenBlock
from .primitives import Mug as Mug
from .primitives import RedBlock as RedBlock
from .primitives import Shape as Shape
from .primitives import Shelf as Shelf
from .primitives import Sphere as Sphere
from .primitives import Tray as Tray
from .primitives import Wall as Wall
from .primitives import YellowBlock as YellowBlock
from .prop import ParametricEntity as ParametricEntity
from .prop import Prop as Prop
from .prop import object_parameters as object_parameters

__getattr__ = lazy_exports(__name__)  # names the package of what has moved
