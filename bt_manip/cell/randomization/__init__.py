"""Domain randomization: variations from cycle to cycle, sampled from the run's seed."""

from .randomization import Randomization as Randomization
from .randomization import SceneObject as SceneObject
from .randomizer import Randomizer as Randomizer
from .variations import extremes as extremes
from .variations import generator as generator
from .variations import parse_variation as parse_variation
