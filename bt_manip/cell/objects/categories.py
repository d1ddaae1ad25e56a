"""Categories of objects: how behaviours may use them."""

import difflib
from collections.abc import Iterable

from bt_manip.exceptions import did_you_mean

from ..exceptions import CellError

CONTAINER = "container"
"""Category of objects that hold others."""

CATEGORIES = (CONTAINER, "graspable", "obstacle", "sensor", "socket", "surface", "thing")
"""The categories of bt-manip; plugins may have more."""

_MISSPELT = 0.8  # [-] difflib ratio above which a word counts as a misspelt category


def check_spelling(category: object) -> None:
    """Refuse a misspelt category of bt-manip; other words may be a plugin's own categories.

    Raises:
        CellError: If it is not a word, or similar to one of `CATEGORIES`.
    """
    if not isinstance(category, str) or not category:
        raise CellError(f"category is a word such as 'graspable', got {category!r}")
    near = difflib.get_close_matches(category.casefold(), CATEGORIES, n=1, cutoff=_MISSPELT)
    if near and category not in CATEGORIES:
        raise CellError(f"category '{category}' is none; did you mean '{near[0]}'?")


def check_known(category: str, known: Iterable[str]) -> None:
    """Refuse an unknown category.

    Raises:
        CellError: If it is neither in `CATEGORIES` nor in ``known``.
    """
    choices = {*CATEGORIES, *known}
    if category not in choices:
        raise CellError(f"category '{category}' is none{did_you_mean(str(category), choices)}")
