"""Scenes: the robots and objects that stand in a cell, from Python or TOML files."""

from .fixtures import add_fixture as add_fixture
from .fixtures import check_supports as check_supports
from .fixtures import fixture_models as fixture_models
from .fixtures import naming_file as naming_file
from .fixtures import place_again as place_again
from .fixtures import sampled_fixtures as sampled_fixtures
from .fixtures import with_models as with_models
from .poses import PHYSICS as PHYSICS
from .poses import ExpectedObjects as ExpectedObjects
from .poses import OperatorPoses as OperatorPoses
from .poses import PoseSource as PoseSource
from .poses import ScenePoses as ScenePoses
from .poses import make_pose_source as make_pose_source
from .scene import Fixture as Fixture
from .scene import Scene as Scene
from .scene import SceneRobot as SceneRobot
from .scene import table_and_basket as table_and_basket
from .scene import two_arms as two_arms
from .scene_file import find_scene as find_scene
from .scene_file import is_scene_file as is_scene_file
from .scene_file import read_scene as read_scene
from .scene_file import scene_of as scene_of
from .scene_file import seed_of as seed_of
from .scene_keys import SceneError as SceneError
from .scene_keys import find_robot as find_robot
