"""Saving configurations in a file."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bt_manip.files import replace_text
from bt_manip.robots import RobotError, load_configurations
from bt_manip.toml import toml_text


def save_configuration(path: Path, name: str, q: Sequence[float]) -> None:
    """Add a configuration to a file of configurations, or replace the one of that name.

    Args:
        path: The file, which is created where there is none.
        name: Its name: letters, digits, ``_`` and ``-``.
        q: Joint positions, written to the microradian [rad].  # (nq,)

    Raises:
        RobotError: If the name is invalid, or the file has anything else or cannot be written.
    """
    if not re.fullmatch(r"[A-Za-z0-9_-]+", name) or name == "home":
        raise RobotError(
            "a configuration is named with letters, digits, '_' and '-', and not 'home', got "
            f"{name!r}"
        )
    known: dict[str, Any] = load_configurations(path) if path.exists() else {}
    if mapped := [other for other, positions in known.items() if isinstance(positions, Mapping)]:
        raise RobotError(f"{path}: '{mapped[0]}' comes from a waypoint file; choose another file")
    known[name] = [round(position, 6) for position in np.asarray(q).tolist()]
    head = "Joint positions [rad], in the order of the joints."
    try:
        replace_text(path, toml_text({"configurations": known}, {}, head))
    except OSError as error:
        raise RobotError(f"cannot write {path}: {error.strerror}") from error
