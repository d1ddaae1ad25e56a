"""Atomic writing of files."""

import os
import stat
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from bt_manip.exceptions import BtManipError


def check_writable(path: Path, what: str) -> None:
    """Check that a file can be written later, without changing it.

    Args:
        path: The file.
        what: Purpose, the first word of the message: ``"report"``.

    Raises:
        BtManipError: When it cannot be written.
    """
    target = _target(path)
    problem = ""
    if target.is_dir():
        problem = "it is a folder"
    elif not target.parent.exists():
        problem = f"there is no folder '{path.parent}'"
    elif not target.parent.is_dir():
        problem = f"'{path.parent}' is not a folder"
    elif target.exists() and not os.access(target, os.W_OK):
        problem = "the file is read-only"
    elif not _is_special(target):
        part = _part(target)
        try:
            part.touch(exist_ok=False)
            part.unlink()
        except OSError as error:
            problem = error.strerror or str(error)
    if problem:
        raise BtManipError(f"{what} '{path}' cannot be written: {problem}")


@contextmanager
def whole_file(path: Path) -> Iterator[BinaryIO]:
    """Open a temporary file for writing, and rename it to ``path`` at the end of the block.

    When the block raises, an existing file remains unchanged. Pipes and devices are written
    directly.
    """
    target = _target(path)
    if _is_special(target):
        with target.open("wb") as file:
            yield file
        return
    part = _part(target)
    try:
        with part.open("xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        part.replace(target)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def _target(path: Path) -> Path:
    """Resolve links: the target of a link is replaced, not the link."""
    return Path(os.path.realpath(path))


def _part(target: Path) -> Path:
    return target.with_name(f".{target.name}.{uuid.uuid4().hex[:8]}.part")


def _is_special(target: Path) -> bool:
    """Return whether the path is a pipe or device, which cannot be replaced by a file."""
    try:
        mode = target.stat().st_mode
    except OSError:
        return False
    return not stat.S_ISREG(mode) and not stat.S_ISDIR(mode)
