"""Writing of TOML with comments."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

BARE_KEY = re.compile("[A-Za-z0-9_-]+")
"""A key without quotes in TOML."""

_WIDTH = 100  # maximum number of columns


def toml_text(entries: Mapping[str, Any], notes: Mapping[str, str], head: str) -> str:
    """Return plain data as TOML with comments.

    Args:
        entries: The data: texts, numbers, booleans, lists and mappings of these.
        notes: Comments by key, such as ``"velocity"`` or ``"gripper.max_force"``.
        head: Comment at the beginning.
    """
    return "\n".join([*_comment(head), *_table("", entries, notes), ""])


def toml_key(name: str) -> str:
    """Return a key, with quotes if TOML requires them."""
    return name if BARE_KEY.fullmatch(name) else json.dumps(name, ensure_ascii=False)


def _table(name: str, entries: Mapping[str, Any], notes: Mapping[str, str]) -> Iterator[str]:
    """Yield an empty line and the lines of a table; the root table has an empty name."""
    inner = {key: value for key, value in entries.items() if isinstance(value, Mapping)}
    if len(inner) < len(entries) or not entries:
        yield ""
        yield from _comment(notes.get(name, ""))
        if name:
            yield f"[{name}]"
    prefix = f"{name}." if name else ""
    for key, value in entries.items():
        if key not in inner:
            yield from _comment(notes.get(prefix + key, ""))
            yield from _assigned(toml_key(key), value)
    for key, value in inner.items():
        yield from _table(prefix + toml_key(key), value, notes)


def _assigned(key: str, value: Any) -> Iterator[str]:
    """Yield the lines of a key; long lists are wrapped."""
    text = f"{key} = {_value(value)}"
    if len(text) <= _WIDTH or isinstance(value, str) or not isinstance(value, Sequence):
        yield text
        return
    lines = [""]
    for item in value:
        part = f"{_value(item)}, "
        if lines[-1] and len(lines[-1]) + len(part) > _WIDTH - 4:
            lines.append("")
        lines[-1] += part
    yield from (f"{key} = [", *(f"    {line.rstrip()}" for line in lines), "]")


def _comment(text: str) -> list[str]:
    return [f"# {line}".rstrip() for line in text.splitlines()]


def _value(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{toml_key(k)} = {_value(v)}' for k, v in value.items())}}}"
    if isinstance(value, Sequence):
        return f"[{', '.join(_value(item) for item in value)}]"
    return repr(value + 0.0 if isinstance(value, float) else value)
