"""Sentences about objects to put into a box, and the goal condition."""

import contextlib
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from bt_manip.behaviours import CellCondition, Destination, extent
from bt_manip.bt import Input, Output, Status, SyncAction
from bt_manip.cell import Cell, is_within, why_not_in
from bt_manip.exceptions import BtManipError, PortError, did_you_mean

AUTO = "auto"
"""Text of a port whose sentence is sampled from the seed."""

FORM = "put the red can and the blue can into the box, or: put all cans into the box"
"""Examples of sentences, for messages."""

_SENTENCE = re.compile(r"put (?P<what>.+) into the box\.?", re.IGNORECASE)
_ALL = re.compile(r"all (?P<word>\w+)s", re.IGNORECASE)
_ONE = re.compile(r"the (?P<kind>\w+(?: \w+)*)", re.IGNORECASE)


def kinds_in(sentence: str, known: Iterable[str]) -> list[str]:
    """Return the kinds of objects in a sentence, in its order.

    Args:
        sentence: The sentence.
        known: Known kinds: ``the red can`` is the kind ``red_can``, ``all cans`` are the kinds with
            the suffix ``can``.

    Raises:
        BtManipError: If it has another form, or an unknown kind.
    """
    kinds, found = sorted(known), dict[str, None]()
    match = _SENTENCE.fullmatch(sentence.strip())
    for phrase in re.split(r", and |, | and ", match["what"]) if match else [""]:
        if one := _ALL.fullmatch(phrase):
            meant = [kind for kind in kinds if kind.endswith(f"_{one['word'].lower()}")]
        elif one := _ONE.fullmatch(phrase):
            kind = one["kind"].lower().replace(" ", "_")
            meant = [kind] if kind in kinds else []
        else:
            raise BtManipError(f"'{sentence}' is not understood; say: {FORM}")
        if not meant:
            near = did_you_mean(phrase, [f"the {kind.replace('_', ' ')}" for kind in kinds])
            raise BtManipError(f"'{sentence}': there is no '{phrase}'{near}")
        found.update(dict.fromkeys(meant))
    return list(found)


class ReadSentence(SyncAction):
    """Read the objects in a sentence; without a sentence, sample one."""

    drawn = ("task",)

    sentence = Input(str, default=AUTO, doc=f"For example: {FORM}; auto: sampled from the seed.")
    drawn_from = Input(str, default="can", doc="Suffix of the kinds in a sampled sentence.")
    task = Output(str, doc="The sentence.")
    objects = Output(list[str], doc="Names of its objects in the cell.")

    def setup(self, **infrastructure: Any) -> None:
        """Store the cell and its random generator, and check the sentence if it is known.

        Raises:
            BtManipError: If the sentence is not understood.
        """
        self.cell: Cell = infrastructure["cell"]
        self.rng = infrastructure["rng"]
        with contextlib.suppress(PortError):  # the entry is not written yet
            if (sentence := self.sentence) != AUTO:
                kinds_in(sentence, infrastructure["models"].names())

    def update(self) -> Status:
        """Read the sentence, and find its objects in the cell."""
        free = [name for name in self.cell.objects if self.cell.is_free(name)]
        kinds = {name: getattr(self.cell.entities[name], "kind", "") for name in free}
        sentence = self._draw(kinds.values()) if self.sentence == AUTO else self.sentence
        try:
            named = kinds_in(sentence, kinds.values())
        except BtManipError as error:
            return self.fail(str(error))
        self.task = sentence
        self.objects = names = [name for kind in named for name in free if kinds[name] == kind]
        self.feedback_message = f"'{sentence}': {', '.join(names)}"
        return Status.SUCCESS

    def _draw(self, kinds: Iterable[str]) -> str:
        """Sample a sentence with some of the objects, or all."""
        word = self.drawn_from
        names = sorted({kind.replace("_", " ") for kind in kinds if kind.endswith(f"_{word}")})
        count = int(self.rng.integers(len(names))) + 1 if names else 0
        if count == len(names):
            return f"put all {word}s into the box"
        chosen = [f"the {names[i]}" for i in self.rng.permutation(len(names))[:count]]
        return f"put {' and '.join(chosen)} into the box"


class HoldsExactly(CellCondition):
    """Check that a container holds the given objects, at rest, and no others, moving or not."""

    container = Input(str, doc="Name of the container.")
    objects = Input(list[str], doc="Names of the objects, separated by ';'.")

    def why_not(self) -> str:
        """Check each freely moving object."""
        outside = (why_not_in(self.cell, name, self.container) for name in self.objects)
        others = (f"'{name}' is in it, too" for name in self._wrong())
        return "; ".join([*filter(None, outside), *others])

    def places(self) -> Mapping[str, Destination | None]:
        """Return the inside of the container for the given objects, and None for others in it."""
        inside = Destination.inside(self.cell, self.container)
        return dict.fromkeys(self._wrong()) | dict.fromkeys(self.objects, inside)

    def _wrong(self) -> list[str]:
        """Return the names of further objects inside."""
        cell, inside = self.cell, self.container
        lower, upper = extent(cell, inside)
        found = []
        for name in cell.objects:
            if name in (inside, *self.objects) or not cell.is_free(name):
                continue
            middle = np.mean(extent(cell, name), axis=0)
            between = ((lower <= middle) & (middle <= upper))[:2].all()
            if between and is_within(cell, name, inside):  # rays are slow
                found.append(name)
        return found
