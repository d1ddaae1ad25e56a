"""Episodes that differ: what varies, drawn by composer's variations from the run's seed."""

from bt_manip.cell.randomization.randomization import Randomization as Randomization
from bt_manip.cell.randomization.randomizer import Randomizer as Randomizer
from bt_manip.cell.randomization.sampling import generator as generator
from bt_manip.cell.randomization.scene_objects import SceneObject as SceneObject
from bt_manip.cell.randomization.variations import parse_variation as parse_variation
