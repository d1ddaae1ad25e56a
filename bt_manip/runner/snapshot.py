"""Snapshots of runs, stations and cells in files."""

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError, shown
from bt_manip.files import read_text, replace_text

FORMAT = "bt-manip snapshot"
VERSION = 7

MAX_SNAPSHOT_BYTES = 2**28  # 256 MiB; a cell with 1000 objects takes a few

_PLAIN = (bool, int, float, str, type(None))


def save_snapshot(path: str | os.PathLike[str], state: Mapping[str, Any]) -> None:
    """Write a state to a file, as JSON: every number comes back to the last bit.

    Args:
        path: The file; an existing one is replaced.
        state: The state of a run, a station or a cell, or several of them in a dict.

    Raises:
        BtManipError: If a value is not plain data, or the file cannot be written.
    """
    path = Path(path)
    _check(state, "")
    content = {"format": FORMAT, "version": VERSION, "sha256": _digest(state), "state": state}
    try:
        replace_text(path, json.dumps(content))
    except OSError as error:
        raise BtManipError(f"cannot write the snapshot {path}: {error.strerror}") from error


def load_snapshot(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read a state from a file.

    Raises:
        BtManipError: If the file cannot be read, is not a snapshot of this version, is not as it
            was written, or has NaN.
    """
    try:
        content = json.loads(read_text(Path(path), MAX_SNAPSHOT_BYTES), parse_constant=_constant)
    except OSError as error:
        raise BtManipError(f"cannot read the snapshot {path}: {error.strerror}") from error
    except RecursionError:
        raise BtManipError(f"{path} is no snapshot: nested too deep") from None
    except ValueError as error:
        raise BtManipError(f"{path} is no snapshot: {error}") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise BtManipError(f"{path} is no snapshot")
    if content.get("version") != VERSION:
        raise BtManipError(
            f"{path} is a snapshot of version {shown(content.get('version'))}, expected {VERSION}"
        )
    if not isinstance(content.get("state"), dict):
        raise BtManipError(f"{path} is no snapshot: it has no table 'state'")
    if content.get("sha256") != _digest(content["state"]):
        raise BtManipError(f"{path} is damaged: its state is not the one that was written")
    return content["state"]


def _digest(state: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(state).encode()).hexdigest()


def _constant(name: str) -> float:
    """Read one of the numbers that JSON itself does not have."""
    if name == "NaN":
        raise ValueError("a number of its state is NaN")
    return float(name)


def _check(value: Any, where: str) -> None:
    """Raise a `BtManipError` for a value that JSON does not preserve."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            if not isinstance(key, str):
                raise BtManipError(f"the state has the key {key!r} at '{where}', keys are strings")
            _check(item, f"{where}/{key}")
    elif isinstance(value, list | tuple):
        for i, item in enumerate(value):
            _check(item, f"{where}/{i}")
    elif not isinstance(value, _PLAIN):
        raise BtManipError(
            f"the state has a {type(value).__name__} at '{where}', which is no plain data"
        )
