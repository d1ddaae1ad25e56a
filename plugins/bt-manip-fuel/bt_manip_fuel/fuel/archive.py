"""Unpacking of untrusted zip archives."""

import stat
import unicodedata
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from bt_manip.models import ModelError

_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_ENCRYPTED = 0x1
_CHUNK = 1 << 20


@dataclass(frozen=True)
class ZipLimits:
    """Limits of a model's archive.

    Attributes:
        files: Maximum number of entries.
        total: Maximum size of all files [bytes].
        ratio: Maximum ratio of unpacked to packed size, for archives above `small`.
        small: Size up to which the ratio is not checked [bytes].
    """

    files: int = 20_000
    total: int = 2 * 2**30
    ratio: float = 200.0
    small: int = 16 * 2**20


def unpack(archive: Path, into: Path, limits: ZipLimits | None = None) -> None:
    """Check all entries of a zip archive, then unpack it.

    Only files and folders are written, inside `into`, with the permissions of new files.

    Args:
        archive: The archive.
        into: An empty folder.
        limits: Limits; defaults when None.

    Raises:
        ModelError: If it is broken, exceeds a limit, or has forbidden entries.
    """
    limits = limits or ZipLimits()
    try:
        with zipfile.ZipFile(archive) as opened:
            entries = opened.infolist()
            _check_sizes(entries, archive.stat().st_size, limits)
            places = [(info, _place(info)) for info in entries]
            _check_twice([place for _, place in places])
            left = limits.total
            for info, place in places:
                target = into / place
                if info.is_dir():
                    target.mkdir(parents=True, exist_ok=True)
                    continue
                target.parent.mkdir(parents=True, exist_ok=True)
                left -= _copy(opened, info, target, left)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError) as error:
        raise ModelError(f"the zip is broken: {error}") from None
    except (OSError, ValueError, OverflowError) as error:
        raise ModelError(f"the zip cannot be unpacked: {error}") from None


def _check_sizes(entries: list[zipfile.ZipInfo], packed: int, limits: ZipLimits) -> None:
    if len(entries) > limits.files:
        raise ModelError(f"the zip has {len(entries)} entries, more than {limits.files}")
    total = sum(info.file_size for info in entries)
    if total > limits.total:
        raise ModelError(f"the zip would come to {total} bytes, more than {limits.total}")
    if total > limits.small and total > limits.ratio * packed:
        raise ModelError(
            f"the zip would grow from {packed} to {total} bytes, more than {limits.ratio:g}-fold: "
            "a bomb"
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
    if info.flag_bits & _ENCRYPTED:
        raise ModelError(f"{shown}: it is encrypted")
    if info.compress_type not in _METHODS:
        raise ModelError(f"{shown}: it is packed by another method than store or deflate")
    return place


def _check_twice(places: list[PurePosixPath]) -> None:
    seen: set[PurePosixPath] = set()
    for place in places:
        if place in seen:
            raise ModelError(f"the zip has two entries '{place}'")
        seen.add(place)


def _copy(opened: zipfile.ZipFile, info: zipfile.ZipInfo, target: Path, limit: int) -> int:
    """Write one file; zipfile verifies its checksum at the end."""
    size = 0
    with opened.open(info) as source, target.open("xb") as file:
        while chunk := source.read(_CHUNK):
            size += len(chunk)
            if size > min(info.file_size, limit):
                raise ModelError(f"the zip's '{info.filename}' is longer than it says: a bomb")
            file.write(chunk)
    if size != info.file_size:
        raise ModelError(
            f"the zip's '{info.filename}' has {size} bytes where it says {info.file_size}"
        )
    return size
