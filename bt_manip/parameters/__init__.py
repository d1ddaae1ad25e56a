"""Parameters: declared once with type, unit, default, bounds and meaning."""

from .declared import parameters_of as parameters_of
from .declared import read_words as read_words
from .parameter import MISSING as MISSING
from .parameter import Parameter as Parameter
