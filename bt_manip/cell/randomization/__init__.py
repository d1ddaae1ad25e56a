"""Episodes that differ: what varies, drawn by composer's variations from the run's seed."""

from bt_manip.cell.randomization.draws import generator as generator
from bt_manip.cell.randomization.notation import variation_of as variation_of
from bt_manip.cell.randomization.randomization import Randomization as Randomization
from bt_manip.cell.randomization.randomizer import Randomizer as Randomizer
from bt_manip.cell.randomization.stands import Stand as Stand
