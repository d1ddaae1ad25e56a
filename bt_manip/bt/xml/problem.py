"""Problems of a tree document, with their places."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from bt_manip.exceptions import did_you_mean, shortened

MAX_SUGGESTED_NAMES: Final = 12
"""Longer lists of names are left out of messages."""

MAX_HINTS: Final = 100
"""Number of findings after which names are no longer compared with the valid ones."""

ERROR: Final = "error"
WARNING: Final = "warning"

_EDIT: Final = re.compile(
    r"(?:key '(?:[^']*\.)?([^'.]+)' means nothing|'([^']+)'(?: has no meaning| that is \w+ here)?)"
    r"; did you mean '([^']+)'"
)
"""What a message names, and what it suggests in its place."""


class Place(NamedTuple):
    """A place in a document.

    Attributes:
        file: The file as the user named it, or ``<text>``.
        line: Its line, from 1; 0 where it is not known.
        column: Its column, from 1, in characters; 0 where it is not known.
    """

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        """Write the place as editors and compilers do."""
        return ":".join(str(part) for part in self if part)


class Edit(NamedTuple):
    """A change of a document that a finding suggests.

    Attributes:
        replace: A text at the place or after it, as a whole word.
        by: What its first occurrence there becomes.
        place: Where; None: at the place of the finding.
    """

    replace: str
    by: str
    place: Place | None = None


@dataclass(frozen=True)
class Problem:
    """One finding.

    Attributes:
        place: Where.
        message: The problem, the text that was found, and the expected one.
        severity: ``error`` or ``warning``.
        code: The kind of finding, such as ``never-runs``; empty where it has no name of its own.
        edit: A change that removes it, if one is evident; else `plain` reads one off the message.
    """

    place: Place
    message: str
    severity: str = ERROR
    code: str = ""
    edit: Edit | None = None

    @property
    def is_error(self) -> bool:
        """Whether the document cannot be used because of this."""
        return self.severity == ERROR

    def plain(self) -> dict[str, Any]:
        """Return the finding as types of JSON, with the edit that it suggests, if any.

        Without a name of its own, its code is its severity.
        """
        kind: dict[str, Any] = {"code": self.code or self.severity, "severity": self.severity}
        found = kind | self.place._asdict() | {"message": self.message}
        edit = self.edit
        if edit is None and (named := _EDIT.search(self.message)):
            edit = Edit(named[1] or named[2], named[3])
        if edit is not None:
            found["suggestion"] = {"replace": edit.replace, "with": edit.by}
            if edit.place not in (None, self.place):
                found["suggestion"] |= {"line": edit.place.line, "column": edit.place.column}
        return found

    def __str__(self) -> str:
        """Write the finding on one line."""
        return f"{self.place}: {self.severity}: {self.message}"


class Problems:
    """Collects findings, each of them once, with hints in the first errors."""

    def __init__(self, hints: int = MAX_HINTS) -> None:
        self._found: dict[Problem, None] = {}
        self._hints = hints

    def error(self, place: Place, message: str, code: str = "") -> None:
        """Add an error."""
        self._found.setdefault(Problem(place, message, ERROR, code))

    def warning(self, place: Place, message: str, code: str = "", edit: Edit | None = None) -> None:
        """Add a warning."""
        self._found.setdefault(Problem(place, message, WARNING, code, edit))

    def unknown(self, place: Place, text: str, name: str, valid: Iterable[str]) -> None:
        """Add the error of an unknown name, such as ``no tree is named 'Mian'``, with hints."""
        text = f"{text} '{shortened(name)}'{self.hint(name, valid)}"
        self.error(place, text, "unknown-name")

    def hint(self, name: str, valid: Iterable[str]) -> str:
        """Name the valid choices nearest to a mistyped one, as `hint` does, in the first errors."""
        return hint(name, valid) if len(self._found) < self._hints else ""

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
