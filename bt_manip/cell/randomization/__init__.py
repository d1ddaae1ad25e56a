"""Domain randomization: values that vary from cycle to cycle, sampled from the run's seed."""

from .randomization import InitialObject as InitialObject
from .randomization import Randomization as Randomization
from .randomizer import Randomizer as Randomizer
from .variations import extremes as extremes
from .variations import generator as generator
from .variations import parse_variation as parse_variation
