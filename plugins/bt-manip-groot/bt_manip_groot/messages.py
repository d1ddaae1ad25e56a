"""Requests and replies of the protocol between Groot2 and BehaviorTree.CPP, version 2."""

import struct
from typing import Any

HEADER_LENGTH = 6
"""Version, type and number of a request [bytes]."""

PROTOCOL_VERSION = b"\x02"

HIGHEST_UID = 0xFFFF
"""Largest uid of a node in the protocol."""


class RequestError(Exception):
    """A request that is answered by its message."""


def field_of(data: Any, name: str, kind: type[Any], below: int = 0) -> Any:
    """Return a field of a JSON object; an integer is from 0 to less than `below`.

    Raises:
        RequestError: If it is missing or invalid.
    """
    value: Any = data.get(name) if isinstance(data, dict) else None
    if type(value) is not kind or (kind is int and not 0 <= value < below):
        limits = f" from 0 to {below - 1}" if kind is int else ""
        raise RequestError(f"'{name}' must be of type {kind.__name__}{limits}")
    return value


def transition(microseconds: int, uid: int, status: int) -> bytes:
    """Return a change of a status, as Groot2 and its log files encode it."""
    return microseconds.to_bytes(6, "little") + struct.pack("<HB", uid, status)
