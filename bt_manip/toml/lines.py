"""Line numbers of keys in a TOML file."""

import re
from collections.abc import Iterable

Place = tuple[str | int, ...]
"""Path of a key: keys from outermost to innermost, with indices of arrays of tables from 1."""

_PART = r"""(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')"""
_KEY = rf"{_PART}(?:\s*\.\s*{_PART})*"
_HEADER = re.compile(rf"\s*\[\s*({_KEY})\s*\]")
_ARRAY = re.compile(rf"\s*\[\[\s*({_KEY})\s*\]\]")
_ASSIGNMENT = re.compile(rf"\s*({_KEY})\s*=")


def line_numbers(text: str) -> dict[Place, int]:
    """Return the line numbers of keys and tables of a text, from 1.

    Keys in inline values have no line of their own; inline tables of an array have, one each.

    The result is approximate, for messages: lines of a multi-line string that look like keys count
    as keys.
    """
    lines: dict[Place, int] = {}
    counts: dict[Place, int] = {}
    inside: Place = ()
    rows: Place = ()  # an array of inline tables, each in a line
    for number, line in enumerate(text.splitlines(), 1):
        if array := _ARRAY.match(line):
            place = _counted(_parts(array[1]), counts)
            counts[place] = counts.get(place, 0) + 1
            lines.setdefault(place, number)
            inside = (*place, counts[place])
        elif header := _HEADER.match(line):
            inside = _counted(_parts(header[1]), counts)
        elif assignment := _ASSIGNMENT.match(line):
            place = inside
            for part in _parts(assignment[1]):
                place = (*place, part)
                lines.setdefault(place, number)
            rows = place if line.rstrip().endswith("[") else ()
            continue
        elif rows and line.lstrip().startswith("{"):
            counts[rows] = counts.get(rows, 0) + 1
            lines.setdefault((*rows, counts[rows]), number)
            continue
        else:
            continue
        lines.setdefault(inside, number)
    return lines


def line_of(place: Place, lines: dict[Place, int]) -> int | None:
    """Return the line of a key, or of the innermost enclosing table with a known line."""
    while place and place not in lines:
        place = place[:-1]
    return lines.get(place)


def _parts(key: str) -> Place:
    return tuple(part.strip("\"'") for part in re.findall(_PART, key))


def _counted(parts: Iterable[str | int], counts: dict[Place, int]) -> Place:
    """Insert the present index after each array of tables in a path."""
    *around, last = parts
    place: Place = ()
    for part in around:
        place = (*place, part)
        if place in counts:
            place = (*place, counts[place])
    return (*place, last)
