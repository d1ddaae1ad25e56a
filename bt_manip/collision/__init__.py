"""Collision checking of arms, with MuJoCo's own collision detection."""

from .adjacent_links import hull_points as hull_points
from .collision_world import PADDING as PADDING
from .collision_world import CollisionPair as CollisionPair
from .collision_world import CollisionWorld as CollisionWorld
from .free_space import DISTANCE_TOLERANCE as DISTANCE_TOLERANCE
from .free_space import PATH_STEP as PATH_STEP
from .free_space import FreeSpace as FreeSpace
from .inter_robot_distance import INTER_ROBOT_CLEARANCE as INTER_ROBOT_CLEARANCE
from .inter_robot_distance import INTER_ROBOT_STEP as INTER_ROBOT_STEP
from .inter_robot_distance import InterRobotDistance as InterRobotDistance
from .robot_geometry import OtherRobot as OtherRobot
from .robot_geometry import RobotGeometry as RobotGeometry
from .robot_geometry import moved_bodies as moved_bodies
from .self_collision import check_home as check_home
from .self_collision import permanent_self_collisions as permanent_self_collisions
from .self_collision import self_collisions as self_collisions
