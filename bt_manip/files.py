"""Bounded reading and atomic writing of the files that a user names, and the cache folder."""

import errno
import hashlib
import os
import shutil
import stat
import uuid
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from math import inf
from pathlib import Path
from typing import BinaryIO

MAX_BYTES = 64 * 2**20
"""Largest file that is read unless a caller says otherwise [bytes]; models have large meshes."""

CACHE_VARIABLE = "BT_MANIP_CACHE"
"""Environment variable with the cache folder."""

_notes: ContextVar[tuple[dict[str, str], ...]] = ContextVar("notes", default=())


def read_bytes(path: Path | str, limit: int = MAX_BYTES) -> bytes:
    """Return the content of a regular file.

    Args:
        path: The file.
        limit: Size of the largest file that is read [bytes].

    Raises:
        OSError: If it cannot be read, is not a regular file (a folder, device or pipe), or is
            larger than the limit; ``strerror`` has the reason.
    """
    path = Path(path)
    check_regular(path, limit)
    with path.open("rb") as file:  # files of the system may be longer than their size says
        data = file.read(limit + 1)
    _check_size(path, len(data), limit)
    if _notes.get():
        note(path.name, hashlib.sha256(data).hexdigest())
    return data


@contextmanager
def noting(found: dict[str, str]) -> Iterator[None]:
    """Note the files that are read inside, in this thread.

    Args:
        found: Gets the SHA-256 of each, by name; of several of one name, all of them.
    """
    before = _notes.set((*_notes.get(), found))
    try:
        yield
    finally:
        _notes.reset(before)


def note(name: str, digest: str) -> None:
    """Note what was read, in each block of `noting` around."""
    for found in _notes.get():
        found[name] = " ".join(sorted({digest, *found.get(name, "").split()}))


def note_files(name: str, paths: Collection[Path]) -> None:
    """Note files that others read as one part.

    Args:
        name: The part: ``"files of w.xml"``.
        paths: The files, of which each exists.
    """
    if paths and _notes.get():
        digest = hashlib.sha256()
        for path in sorted(paths):
            with path.open("rb") as file:
                digest.update(hashlib.file_digest(file, "sha256").digest())
        note(name, digest.hexdigest())


def read_text(path: Path | str, limit: int = MAX_BYTES) -> str:
    """Return the content of a regular file in UTF-8.

    Raises:
        OSError: As for `read_bytes`.
        UnicodeDecodeError: If it is not UTF-8.
    """
    return read_bytes(path, limit).decode("utf-8")


def check_regular(path: Path, limit: float = inf) -> None:
    """Check that a path is a regular file of at most this size [bytes].

    Raises:
        OSError: If it is not; ``strerror`` has the reason.
    """
    try:
        found = path.stat()
    except ValueError:  # a NUL character
        raise OSError(errno.ENOENT, "not the path of a file", str(path)) from None
    if not stat.S_ISREG(found.st_mode):
        what = "a folder" if stat.S_ISDIR(found.st_mode) else "not a regular file"
        raise OSError(errno.EINVAL, what, str(path))
    _check_size(path, found.st_size, limit)


def _check_size(path: Path, size: int, limit: float) -> None:
    if size > limit:
        raise OSError(errno.EFBIG, f"larger than {limit / 2**20:g} MB", str(path))


@contextmanager
def whole_file(path: Path, *, sync: bool = True) -> Iterator[BinaryIO]:
    """Open a temporary file for writing, and rename it to ``path`` at the end of the block.

    When the block raises, an existing file remains unchanged. Pipes and devices are written
    directly.

    Args:
        path: The file.
        sync: Whether to wait until it is on the disk, so that it survives a crash of the system.
    """
    target = resolved(path)
    if is_special(target):
        with target.open("wb") as file:
            yield file
        return
    part = part_of(target)
    try:
        with part.open("x+b") as file:  # h5py reads what it writes
            yield file
            file.flush()
            if sync:
                os.fsync(file.fileno())
        if target.exists():
            shutil.copymode(target, part)
        part.replace(target)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


def replace_text(path: Path, text: str) -> None:
    """Write a text file in UTF-8, so that an existing one is replaced as a whole or not at all.

    Raises:
        OSError: If it cannot be written.
    """
    with whole_file(path) as file:
        file.write(text.encode())


def resolved(path: Path) -> Path:
    """Resolve links: the target of a link is replaced, not the link."""
    return Path(os.path.realpath(path))


def part_of(target: Path) -> Path:
    """Return the name of a temporary file beside a file."""
    return target.with_name(f".{target.name}.{uuid.uuid4().hex[:8]}.part")


def is_special(target: Path) -> bool:
    """Return whether the path is a pipe or device, which cannot be replaced by a file."""
    try:
        mode = target.stat().st_mode
    except OSError:
        return False
    return not stat.S_ISREG(mode) and not stat.S_ISDIR(mode)


def cache_root() -> Path:
    """Return the cache folder."""
    if given := os.environ.get(CACHE_VARIABLE, ""):
        return Path(given)
    import platformdirs

    return platformdirs.user_cache_path("bt_manip")
