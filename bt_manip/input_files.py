"""Bounded reading of the files that a user names."""

import errno
import re
import stat
import tomllib
from math import inf
from pathlib import Path
from typing import Any

MAX_BYTES = 64 * 2**20
"""Largest file that is read unless a caller says otherwise [bytes]; models have large meshes."""

MAX_TOML_BYTES = 4 * 2**20
MAX_TOML_NESTING = 64
"""Deepest nesting of tables, lists and dotted keys."""

_TEXT = re.compile(  # strings and comments
    r'''"""(?:\\.|[^\\])*?"""|\'{3}.*?\'{3}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'|#[^\n]*''', re.DOTALL
)
_DOTTED = re.compile(rf"(?:[\w-]+[ \t]*\.[ \t]*){{{MAX_TOML_NESTING}}}")


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


def read_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file.

    Raises:
        OSError: If it cannot be read.
        ValueError: As for `parse_toml`.
    """
    return parse_toml(read_text(path, MAX_TOML_BYTES))


def parse_toml(text: str) -> dict[str, Any]:
    """Return the content of a TOML text.

    Raises:
        ValueError: If it is not TOML, or nested deeper than `MAX_TOML_NESTING`.
    """
    bare = _TEXT.sub("s", text)
    depth = 0
    for bracket in re.findall(r"[][{}]", bare):
        depth += 1 if bracket in "[{" else -1
        if depth > MAX_TOML_NESTING:
            break
    if depth > MAX_TOML_NESTING or _DOTTED.search(bare):
        raise ValueError(f"nested deeper than {MAX_TOML_NESTING} levels")
    return tomllib.loads(text)
