"""Bounded reading of the files that a user names, and the folder of computed ones."""

import errno
import os
import stat
from math import inf
from pathlib import Path

MAX_BYTES = 64 * 2**20
"""Largest file that is read unless a caller says otherwise [bytes]; models have large meshes."""

CACHE_VARIABLE = "BT_MANIP_CACHE"
"""Environment variable with the cache folder."""


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
    return data


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


def cache_root() -> Path:
    """Return the folder in which bt-manip keeps what is slow to compute."""
    if given := os.environ.get(CACHE_VARIABLE, ""):
        return Path(given)
    import platformdirs

    return platformdirs.user_cache_path("bt_manip")
