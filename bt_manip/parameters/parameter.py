"""The declaration of a parameter, and the check of its values."""

import inspect
import re
from dataclasses import dataclass
from math import inf
from typing import Any, Final

from bt_manip.exceptions import shortened, shown

MISSING: Final = inspect.Parameter.empty
"""The default of a parameter that must be given."""

TRUTH: Final = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
"""Texts of truth values."""

_NOUNS = {str: "text", bool: "truth value", int: "whole number", float: "number"}


@dataclass(frozen=True, eq=False)
class Parameter:
    """Declaration of a parameter: of a fault, a recorder, an object, a node, a TOML file, ...

    ``Parameter("Force", "N", 100.0, above=0.0)``

    Attributes:
        meaning: Its meaning, in a sentence.
        unit: Its unit; by default the one in brackets in the meaning: ``"Force [N]."``.
        default: Its default value; `MISSING` if it must be given. With a default of None, None is a
            value.
        above: Exclusive minimum of its numbers.
        at_least: Inclusive minimum.
        below: Exclusive maximum.
        at_most: Inclusive maximum.
        infinite: Whether infinity is a value.
        size: Number of its values, or of least and most; None for a single value. By default that
            of the numbers of the default.
        type: Type of its values, or of each of them: float, int, bool, str, or None for any; by
            default that of the default.
        name: Its name.
    """

    meaning: str = ""
    unit: str = ""
    default: Any = MISSING
    above: float = -inf
    at_least: float = -inf
    below: float = inf
    at_most: float = inf
    infinite: bool = False
    size: Any = None
    type: Any = None
    name: str = ""

    def __post_init__(self) -> None:
        """Take type, size and unit from default and meaning where they are not given."""
        first = self.default
        if isinstance(first, list | tuple) and first and not isinstance(first[0], list | tuple):
            if self.size is None:
                size = (0, inf) if isinstance(first[0], str) else len(first)
                object.__setattr__(self, "size", size)
            first = first[0]
        if self.type is None and type(first) in _NOUNS:
            object.__setattr__(self, "type", type(first))
        if not self.unit and (unit := re.search(r"\[([^\]]+)\]", self.meaning)):
            object.__setattr__(self, "unit", unit[1])

    @property
    def bounds(self) -> str:
        """The bounds in words: ``above 0 and at most 1``; empty if there are none."""
        if self.at_least > -inf and self.at_most < inf:
            return f"from {self.at_least:g} to {self.at_most:g}"
        named = {"above": self.above, "at least": self.at_least,
                 "below": self.below, "at most": self.at_most}  # fmt: skip
        return " and ".join(
            f"{word} {bound:g}" for word, bound in named.items() if abs(bound) < inf
        )

    def bounded(self, noun: str) -> str:
        """Return a noun with the bounds: ``positive number``, ``number of at least 0``."""
        if self.bounds == "above 0":
            return f"positive {noun}"
        return f"{noun} {'of ' if self.bounds.startswith('at') else ''}{self.bounds}".strip()

    @property
    def form(self) -> str:
        """Its values in words, without the unit: ``3 positive numbers``."""
        noun, size = _NOUNS.get(self.type, "value"), self.size
        if size is None:
            return "true or false" if self.type is bool else self.bounded(noun)
        least, most = size if isinstance(size, tuple) else (size, size)
        count = (
            f"{least} {'or' if most == least + 1 else 'to'} {most} " if least < most else f"{most} "
        )
        return f"{'list of ' if most == inf else count}{self.bounded(f'{noun}s')}"

    @property
    def wanted(self) -> str:
        """Its values in words, for messages: ``a number of at least 0 [s]``."""
        article = "" if self.form[0].isdigit() or self.form.startswith("true") else "a "
        return f"{article}{self.form}{self._unit_text}"

    @property
    def wanted_number(self) -> str:
        """A number within the bounds in words: ``a positive number [m]``."""
        return f"a {self.bounded('number')}{self._unit_text}"

    @property
    def _unit_text(self) -> str:
        return f" [{self.unit}]" if self.unit else ""

    @property
    def described(self) -> str:
        """The meaning with the unit, as a sentence."""
        if not self.meaning or self._unit_text in self.meaning:
            return self.meaning
        stop = "." if self.meaning.endswith(".") else ""
        return f"{self.meaning.removesuffix('.')}{self._unit_text}{stop}"

    @property
    def mandatory(self) -> bool:
        """Whether it must be given: it has no default."""
        return self.default is MISSING

    @property
    def default_text(self) -> str:
        """The default as text; empty for None, nested lists, and where there is none."""
        return "" if self.default is MISSING else shortened(_text(self.default))

    @property
    def line(self) -> str:
        """Name, type, bounds, default, meaning and unit in one line, for users."""
        default = f", default {self.default_text}" if self.default_text else ""
        facts = ", required" if self.mandatory else default
        return f"{self.name} ({self.form}{facts}): {self.described}"

    def check(self, value: Any) -> None:
        """Check a value; integers are numbers, arrays are lists.

        Raises:
            ValueError: ``must be a number of at least 0 [s], got -1``.
        """
        if not self.accepts(value):
            raise ValueError(f"must be {self.wanted}, got {shown(value)}")

    def accepts(self, value: Any) -> bool:
        """Return whether a value has the type, the size, and is within the bounds."""
        if value is None and self.default is None:
            return True
        value = value.tolist() if hasattr(value, "tolist") else value
        if self.size is None:
            return self._accepts_one(value)
        if not isinstance(value, list | tuple) or not all(map(self._accepts_one, value)):
            return False
        least, most = self.size if isinstance(self.size, tuple) else (self.size, self.size)
        return bool(least <= len(value) <= most)

    def _accepts_one(self, value: Any) -> bool:
        """Return whether a single value has the type and is within the bounds."""
        if self.type in (str, bool):
            return isinstance(value, self.type)
        if self.type not in (int, float):
            return True
        if isinstance(value, bool) or not isinstance(value, int | float):
            return False
        return self.within(value) and (self.type is float or value % 1 == 0)

    def within(self, number: float) -> bool:
        """Return whether a number is within the bounds; NaN is not."""
        within = self.above < number and self.at_least <= number <= self.at_most
        return within and (number < self.below or self.infinite)

    def read(self, text: str) -> Any:
        """Return the value that a text stands for; a text where the type has no other form.

        Raises:
            ValueError: ``must be a whole number of at least 1, got 'x'``.
        """
        value: Any = text
        try:
            if self.type is bool:
                value = TRUTH[text.lower()]
            elif self.type in (int, float):
                value = self.type(text)
            if self.accepts(value):
                return value
        except (KeyError, ValueError):
            pass
        raise ValueError(f"must be {self.wanted}, got {shown(text)}")


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list | tuple):
        nested = any(isinstance(item, list | tuple) for item in value)
        return "" if nested else ", ".join(map(_text, value))
    return value if isinstance(value, str) else shown(value)
