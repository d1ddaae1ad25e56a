"""The one loop: a tree, a cell, a clock."""

from bt_manip.runner.commanded_robot import CommandedRobot as CommandedRobot
from bt_manip.runner.observer import RunObserver as RunObserver
from bt_manip.runner.prepare import prepare as prepare
from bt_manip.runner.request import RunRequest as RunRequest
from bt_manip.runner.run import Run as Run
from bt_manip.runner.scene import Fixture as Fixture
from bt_manip.runner.scene import Scene as Scene
from bt_manip.runner.scene import SceneRobot as SceneRobot
from bt_manip.runner.scene import table_and_basket as table_and_basket
from bt_manip.runner.scene import two_arms as two_arms
from bt_manip.runner.snapshot import load_snapshot as load_snapshot
from bt_manip.runner.snapshot import save_snapshot as save_snapshot
from bt_manip.runner.station import Station as Station
from bt_manip.runner.station import TreeResult as TreeResult
from bt_manip.runner.station import build_station as build_station
from bt_manip.runner.tree_source import TreeSource as TreeSource
from bt_manip.runner.tree_source import find_tree as find_tree

from .fixtures import naming_file as naming_file
from .python_tree import make_tree as make_tree
from .reloading import Reloader as Reloader
from .request import CONTROLLER as CONTROLLER
from .request import SCENE as SCENE
from .scene_choice import find_scene as find_scene
from .scene_choice import is_scene_file as is_scene_file
from .scene_choice import scene_of as scene_of
from .scene_choice import seed_of as seed_of
from .scene_file import SceneError as SceneError
from .stopwatch import Stopwatch as Stopwatch
from .xml_tree import known_behaviours as known_behaviours
from .xml_tree import load_document as load_document
