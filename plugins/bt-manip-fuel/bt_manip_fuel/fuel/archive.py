"""Unpacking of untrusted zip archives."""

import stat
import unicodedata
import zipfile
import zlib
from pathlib import Path, PurePosixPath

from bt_manip.models import ModelError

MAX_FILES = 20_000
"""Largest number of entries."""

MAX_TOTAL = 2 * 2**30
"""Largest size of all files [bytes]."""

MAX_RATIO = 200
"""Largest ratio of unpacked to packed size, for archives above `SMALL`."""

SMALL = 16 * 2**20
"""Size up to which the ratio is not checked [bytes]."""

_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_CHUNK = 1 << 20


def unpack(archive: Path, into: Path) -> None:
    """Check all entries of a zip archive, then unpack it.

    Only files and folders are written, inside `into`, with the permissions of new files.

    Args:
        archive: The archive.
        into: An empty folder.

    Raises:
        ModelError: If it is broken, exceeds a limit, or has forbidden entries.
    """
    try:
        with zipfile.ZipFile(archive) as opened:
            entries = opened.infolist()
            _check_sizes(entries, archive.stat().st_size)
            places = [_place(info) for info in entries]  # all, before any is written
            left = MAX_TOTAL
            for info, place in zip(entries, places, strict=True):
                target = into / place
                if info.is_dir():
                    target.mkdir(parents=True, exist_ok=True)
                    continue
                target.parent.mkdir(parents=True, exist_ok=True)
                left -= _copy(opened, info, target, left)
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError) as error:
        raise ModelError(f"the zip is broken: {error}") from None
    except (OSError, ValueError, OverflowError) as error:
        raise ModelError(f"the zip cannot be unpacked: {error}") from None


def _check_sizes(entries: list[zipfile.ZipInfo], packed: int) -> None:
    if len(entries) > MAX_FILES:
        raise ModelError(f"the zip has {len(entries)} entries, more than {MAX_FILES}")
    total = sum(info.file_size for info in entries)
    if total > MAX_TOTAL:
        raise ModelError(f"the zip would come to {total} bytes, more than {MAX_TOTAL}")
    if total > SMALL and total > MAX_RATIO * packed:
        raise ModelError(
            f"the zip would grow from {packed} to {total} bytes, more than {MAX_RATIO}-fold: a bomb"
        )


def _place(info: zipfile.ZipInfo) -> PurePosixPath:
    """Check one entry; return its path relative to the folder."""
    name = info.orig_filename  # `filename` ends at the first zero character
    if any(unicodedata.category(c) in ("Cc", "Cf", "Cs") for c in name):
        raise ModelError(f"the zip has a file name with control characters: {ascii(name)}")
    shown = f"the zip has an entry '{name}'"
    if not name or name.startswith("/") or "\\" in name or name[1:2] == ":":
        raise ModelError(f"{shown}: its path is absolute or not of the usual form")
    place = PurePosixPath(name)
    if ".." in place.parts:
        raise ModelError(f"{shown}: its path climbs out of the folder")
    kind = stat.S_IFMT(info.external_attr >> 16)
    if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        what = "a link" if kind == stat.S_IFLNK else "neither file nor folder"
        raise ModelError(f"{shown}: it is {what}")
    if info.compress_type not in _METHODS:
        raise ModelError(f"{shown}: it is packed by another method than store or deflate")
    return place


def _copy(opened: zipfile.ZipFile, info: zipfile.ZipInfo, target: Path, limit: int) -> int:
    """Write one file; zipfile verifies its checksum at the end."""
    size = 0
    with opened.open(info) as source, target.open("xb") as file:
        while chunk := source.read(_CHUNK):
            size += len(chunk)
            if size > min(info.file_size, limit):
                raise ModelError(f"the zip's '{info.filename}' is longer than it says: a bomb")
            file.write(chunk)
    if size < info.file_size:
        raise ModelError(f"the zip's '{info.filename}' is shorter than it says")
    return size
