"""A check of one part, as contracts of plugins yield it."""

from collections.abc import Callable
from typing import NamedTuple

from bt_manip.testing.situations import Situations


class Check(NamedTuple):
    """One check of one part; `run` raises `AssertionError` if it fails."""

    id: str
    run: Callable[[Situations], None]
    long: bool = False
    """Whether it takes up to minutes and is only made for ``pytest -m soak``."""
