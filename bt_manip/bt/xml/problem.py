"""Problems of a tree document, with their places."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple

from bt_manip.exceptions import did_you_mean, shortened

MAX_SUGGESTED_NAMES: Final = 12
"""Longer lists of names are left out of messages."""

MAX_HINTS: Final = 100
"""Number of findings after which names are no longer compared with the valid ones."""

ERROR: Final = "error"
WARNING: Final = "warning"


class Place(NamedTuple):
    """A place in a document.

    Attributes:
        file: The file as the user named it, or ``<text>``.
        line: Its line, from 1.
        column: Its column, from 1, in characters.
    """

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        """Write the place as editors and compilers do."""
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True)
class Problem:
    """One finding.

    Attributes:
        place: Where.
        message: The problem, the text that was found, and the expected one.
        severity: ``error`` or ``warning``.
    """

    place: Place
    message: str
    severity: str = ERROR

    @property
    def is_error(self) -> bool:
        """Whether the document cannot be used because of this."""
        return self.severity == ERROR

    def __str__(self) -> str:
        """Write the finding on one line."""
        return f"{self.place}: {self.severity}: {self.message}"


class Problems:
    """Collects findings, each of them once."""

    def __init__(self) -> None:
        self._found: dict[Problem, None] = {}

    def error(self, place: Place, message: str) -> None:
        """Add an error."""
        self._found.setdefault(Problem(place, message))

    def warning(self, place: Place, message: str) -> None:
        """Add a warning."""
        self._found.setdefault(Problem(place, message, WARNING))

    def unknown(self, place: Place, text: str, name: str, valid: Iterable[str]) -> None:
        """Add the error of an unknown name, such as ``no tree is named 'Mian'``, with hints."""
        self.error(place, f"{text} '{shortened(name)}'{self.hint(name, valid)}")

    def hint(self, name: str, valid: Iterable[str]) -> str:
        """Name the valid choices nearest to a mistyped one, as `hint` does, in the first errors."""
        return hint(name, valid) if len(self._found) < MAX_HINTS else ""

    def extend(self, problems: Iterable[Problem]) -> None:
        """Add findings that were collected elsewhere."""
        for problem in problems:
            self._found.setdefault(problem)

    @property
    def errors(self) -> list[Problem]:
        """The errors, in the order of the files and places."""
        return [problem for problem in self if problem.is_error]

    def __iter__(self) -> Iterator[Problem]:
        """Iterate over all findings: file by file as first met, from top to bottom."""
        files: dict[str, int] = {}
        for problem in self._found:
            files.setdefault(problem.place.file, len(files))
        return iter(
            sorted(self._found, key=lambda p: (files[p.place.file], p.place.line, p.place.column))
        )


def hint(name: str, valid: Iterable[str]) -> str:
    """Name the valid choices nearest to a mistyped one; all of them only where they are few."""
    choices = list(valid)
    text = did_you_mean(name, choices)
    return "" if text.startswith("; known") and len(choices) > MAX_SUGGESTED_NAMES else text
