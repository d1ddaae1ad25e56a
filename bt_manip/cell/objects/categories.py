"""What behaviours may do with an object, as one word."""

import difflib
from collections.abc import Iterable

from bt_manip.cell.exceptions import CellError
from bt_manip.exceptions import did_you_mean

CONTAINER = "container"
"""Category of objects that others are put into."""

CATEGORIES = (CONTAINER, "graspable", "obstacle", "sensor", "socket", "surface", "thing")
"""The categories that bt-manip itself knows; plugins may have more."""

_MISSPELT = 0.8  # from here on two words are taken for the same


def refuse_misspelt(category: object) -> None:
    """Refuse what is a category of bt-manip but for its spelling; others may be a plugin's own.

    Raises:
        CellError: When it is no word, or nearly one of `CATEGORIES`.
    """
    if not isinstance(category, str) or not category:
        raise CellError(f"category is a word such as 'graspable', got {category!r}")
    near = difflib.get_close_matches(category.casefold(), CATEGORIES, n=1, cutoff=_MISSPELT)
    if near and category not in CATEGORIES:
        raise CellError(f"category '{category}' is none; did you mean '{near[0]}'?")


def refuse_unknown(category: str, known: Iterable[str]) -> None:
    """Refuse a category that no object has.

    Raises:
        CellError: When it is none of those of bt-manip and none of these.
    """
    choices = {*CATEGORIES, *known}
    if category not in choices:
        raise CellError(f"category '{category}' is none{did_you_mean(str(category), choices)}")
