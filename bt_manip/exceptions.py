"""The errors that bt-manip raises for mistakes that a user can correct."""

import importlib.util
import re
from collections.abc import Iterable
from typing import Any

ANY_BUT_INTERRUPT = (Exception, GeneratorExit, SystemExit)
"""Exceptions of behaviours and plugins that end a run or an episode with a reason."""

_SHOWN = 72  # characters of a value that a message shows
_LISTED = 100  # characters of a list of choices
_COMPARED = 2000  # number of choices among which the nearest are searched

_LONGEST = 120  # characters of a value, such as the path of a file, that messages show whole
_LONG_VALUE = re.compile(rf"(?<!\w)'[^'\n]{{{_LONGEST},}}'(?!\w)|\S{{{_LONGEST},}}")


class BtManipError(Exception):
    """Base of all errors that a user can put right: bad input, a broken model, a bad plugin."""

    def __str__(self) -> str:
        """Return the message, in which long values are cut."""
        return with_short_values(super().__str__())


def did_you_mean(name: str, valid: Iterable[str], *, most: int = 3) -> str:
    """Name the valid choices nearest to a mistyped one.

    Args:
        name: What was written.
        valid: What would have been right.
        most: Maximum number of suggestions.

    Returns:
        ``"; did you mean 'a' or 'b'?"``, or the choices, as many as fit a line, when nothing is
        near, or ``""`` when there is nothing to choose from. Made to be appended to an error
        message.
    """
    import difflib  # by errors alone

    choices = sorted(set(valid))
    by_folded = {choice.casefold(): choice for choice in reversed(choices)}
    folded = name.casefold() if len(name) <= _LISTED else ""  # nothing is near to longer names
    compared = by_folded if len(choices) <= _COMPARED else ()
    near = difflib.get_close_matches(folded, compared, n=most, cutoff=0.6)
    if near:
        return "; did you mean " + " or ".join(f"'{by_folded[n]}'" for n in near) + "?"
    if not choices:
        return ""
    text = ", ".join(choices)
    if len(text) > _LISTED:
        listed = text[:_LISTED].rpartition(", ")[0]
        text = f"{listed} and {len(choices) - listed.count(', ') - 1} more"
    return f"; known: {text}"


def shown(value: Any) -> str:
    """Return the representation of a value in one line of limited length."""
    if isinstance(value, int) and abs(value) > 10**_SHOWN:  # repr raises for the longest
        return f"an integer of {value.bit_length()} bits"
    return shortened(repr(value))


def shortened(text: str) -> str:
    """Return a text, such as a script, in one line of limited length."""
    text = one_line(text)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def with_short_values(text: str) -> str:
    """Return a message in which quoted values and words are cut in the middle where they are long.

    The messages of `BtManipError` and the reasons of failures are cut so.
    """
    if len(text) <= _LONGEST:
        return text
    return _LONG_VALUE.sub(lambda found: f"{found[0][:60]}...{found[0][-20:]}", text)


def one_line(text: object) -> str:
    """Return a text, such as the message of a library's error, in one line."""
    return " ".join(str(text).split())


def without_numbers(text: str, place: str = "") -> str:
    """Return a message without its numbers, to count messages that differ in these only.

    Args:
        text: The message.
        place: Text in place of each number.
    """
    return re.sub(r"-?\d+(\.\d+)?", place, text)


def reason_of(error: BaseException) -> str:
    """Return why an exception ended a run or an episode: its message, with the type of others'."""
    if isinstance(error, BtManipError | NodeError):
        return str(error)
    return with_short_values(f"{type(error).__name__}: {error}".rstrip(": "))


def require_extra(extra: str, what: str, *packages: str) -> None:
    """Check that packages of an extra are installed, without importing them.

    Args:
        extra: Name of the extra: ``"learn"``.
        what: What needs them, the first words of the message: ``"--to"``.
        packages: Names of their top-level modules.

    Raises:
        BtManipError: If one is missing; the message names the extra.
    """
    for package in packages:
        if importlib.util.find_spec(package) is None:
            raise BtManipError(f"{what} needs {package}: pip install 'bt-manip[{extra}]'")


class TreeError(BtManipError):
    """A behaviour tree that cannot be built: its document or its construction is wrong.

    Attributes:
        problems: What is wrong, one item a finding, each with its place in the document.
    """

    def __init__(self, message: str, problems: Iterable[object] = ()) -> None:
        super().__init__(message)
        self.problems = tuple(problems)


class UnknownBehaviourError(TreeError):
    """A name under which no behaviour is registered."""


class PortError(BtManipError):
    """A port that cannot be read or written as asked."""


class BoundsError(PortError):
    """A value of a port outside the bounds that the port declares."""


class BlackboardError(BtManipError):
    """A blackboard entry that is missing, or that does not take a value."""


class ScriptError(BtManipError):
    """A script that cannot be parsed or evaluated."""


class MotionError(BtManipError):
    """A motion that cannot be planned or executed; nothing moves.

    Attributes:
        reason: ``"target"`` (bad input), ``"unreachable"``, ``"line"`` (a tool path that cannot be
            followed to its end), ``"collision"`` (an obstacle blocks the target or every path),
            ``"robot"`` (another robot blocks them, which may move away), ``"stopping"`` (the arm is
            coming to rest after a fault), ``"sensor"`` (a measurement is not finite), ``"effort"``,
            ``"limits"``, ``"device"`` (a real arm that cannot follow) or ``"grasp"`` (an object
            that cannot be gripped).
        fraction: How much of a tool path could be followed, 0 to 1; None where not known.
    """

    def __init__(self, message: str, *, reason: str, fraction: float | None = None) -> None:
        super().__init__(message)
        self.reason, self.fraction = reason, fraction


class NodeError(Exception):
    """An exception raised inside a node of a running tree, with the path of that node.

    Not a `BtManipError`: what went wrong may be a fault of the behaviour. The first exception is
    kept as ``__cause__``.

    Attributes:
        path: The path of the node in its tree.
        registration: The name under which the node's class is registered.
        culprit: Name of the module that the node's class is in; empty when unknown.
    """

    def __init__(self, path: str, registration: str, message: str, culprit: str = "") -> None:
        super().__init__(with_short_values(f"{path} [{registration}]: {message}"))
        self.path = path
        self.registration = registration
        self.culprit = culprit
