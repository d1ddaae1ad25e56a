"""In which line of a TOML file a key stands."""

import re
from collections.abc import Iterable

Place = tuple[str | int, ...]
"""Keys from the outermost one in; in an array of tables, the number of the table, from 1."""

_PART = r"""(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')"""
_KEY = rf"{_PART}(?:\s*\.\s*{_PART})*"
_HEADER = re.compile(rf"\s*\[\s*({_KEY})\s*\]")
_ARRAY = re.compile(rf"\s*\[\[\s*({_KEY})\s*\]\]")
_ASSIGNMENT = re.compile(rf"\s*({_KEY})\s*=")


def line_numbers(text: str) -> dict[Place, int]:
    """Find the lines of keys and tables; of what stands inside a value, that of the value.

    A guess by the look of the lines, for messages: what looks like a key inside a text of several
    lines counts as one.

    Args:
        text: The file.
    """
    lines: dict[Place, int] = {}
    counts: dict[Place, int] = {}
    inside: Place = ()
    for number, line in enumerate(text.splitlines(), 1):
        if array := _ARRAY.match(line):
            place = _counted(_parts(array[1]), counts)
            counts[place] = counts.get(place, 0) + 1
            lines.setdefault(place, number)
            inside = (*place, counts[place])
        elif header := _HEADER.match(line):
            inside = _counted(_parts(header[1]), counts)
        elif assignment := _ASSIGNMENT.match(line):
            lines.setdefault((*inside, *_parts(assignment[1])), number)
            continue
        else:
            continue
        lines.setdefault(inside, number)
    return lines


def line_of(place: Place, lines: dict[Place, int]) -> int | None:
    """Give the line of a key, or that of the nearest table around it that has one."""
    while place and place not in lines:
        place = place[:-1]
    return lines.get(place)


def _parts(key: str) -> Place:
    return tuple(part.strip("\"'") for part in re.findall(_PART, key))


def _counted(parts: Iterable[str | int], counts: dict[Place, int]) -> Place:
    """Say of each array on the way which of its tables is meant: the last one so far."""
    *around, last = parts
    place: Place = ()
    for part in around:
        place = (*place, part)
        if place in counts:
            place = (*place, counts[place])
    return (*place, last)
