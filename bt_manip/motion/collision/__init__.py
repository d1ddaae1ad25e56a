"""What the arm would touch, by the physics' own collision detection."""

from .collision_world import PADDING as PADDING
from .collision_world import CollisionWorld as CollisionWorld
from .collision_world import Near as Near
from .free_space import FreeSpace as FreeSpace
