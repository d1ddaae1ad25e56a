"""Sentences about objects to put into a box, and the goal condition."""

import contextlib
import re
from collections.abc import Iterable
from typing import Any

from bt_manip.behaviours import CellCondition
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
        return "; ".join(self._reasons())

    def progress(self) -> float:
        """Return the share of the given objects that are inside, less the share of others."""
        return max(0.0, 1.0 - len(self._reasons()) / max(len(self.objects), 1))

    def _reasons(self) -> list[str]:
        """Return the reason for each misplaced object."""
        cell, inside = self.cell, self.container
        outside = {name: why_not_in(cell, name, inside) for name in self.objects}
        others = [name for name in cell.objects if cell.is_free(name) and name not in outside]
        wrong = [name for name in others if name != inside and is_within(cell, name, inside)]
        return [*filter(None, outside.values()), *(f"'{name}' is in it, too" for name in wrong)]
