"""Domain randomization: what varies from cycle to cycle, sampled from the run's seed."""

from .randomization import Randomization as Randomization
from .randomizer import Randomizer as Randomizer
from .sampling import generator as generator
from .scene_objects import SceneObject as SceneObject
from .variations import parse_variation as parse_variation
