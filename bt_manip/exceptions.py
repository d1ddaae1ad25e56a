"""The errors that bt-manip raises for what a user can put right."""

import difflib
from collections.abc import Iterable


class BtManipError(Exception):
    """Base of all errors that a user can put right: bad input, a broken model, a bad plugin."""


def did_you_mean(name: str, valid: Iterable[str], *, most: int = 3) -> str:
    """Name the valid choices nearest to a mistyped one.

    Args:
        name: What was written.
        valid: What would have been right.
        most: How many suggestions at the most.

    Returns:
        ``"; did you mean 'a' or 'b'?"``, or all choices when nothing is near, or ``""`` when
        there is nothing to choose from. Made to be appended to an error message.
    """
    choices = sorted(valid)
    by_folded = {choice.casefold(): choice for choice in reversed(choices)}
    near = difflib.get_close_matches(name.casefold(), by_folded, n=most, cutoff=0.6)
    if near:
        return "; did you mean " + " or ".join(f"'{by_folded[n]}'" for n in near) + "?"
    return "; known: " + ", ".join(choices) if choices else ""
