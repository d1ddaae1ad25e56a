"""Everyday objects, and tasks: placing a mug on a shelf, packing cans named in a sentence."""

from bt_manip_everyday.objects import BlueCan as BlueCan
from bt_manip_everyday.objects import Bowl as Bowl
from bt_manip_everyday.objects import CoffeeMug as CoffeeMug
from bt_manip_everyday.objects import GreenCan as GreenCan
from bt_manip_everyday.objects import RedCan as RedCan
from bt_manip_everyday.objects import YellowCan as YellowCan
from bt_manip_everyday.sentences import HoldsExactly as HoldsExactly
from bt_manip_everyday.sentences import ReadSentence as ReadSentence
from bt_manip_everyday.sentences import kinds_in as kinds_in
