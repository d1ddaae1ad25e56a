"""Writing of files: atomic, or by appending."""

import errno
import os
import stat
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO
from zipfile import BadZipFile

from bt_manip.exceptions import BtManipError


class RecordingError(BtManipError):
    """A recording that could not be written."""


def check_writable(path: Path, what: str, *, source: Path | None = None) -> None:
    """Check that a file can be written later, without changing it.

    Args:
        path: The file.
        what: Purpose, the first word of the message: ``"report"``.
        source: The recording that is read, which must be another file.

    Raises:
        BtManipError: When it cannot be written.
    """
    target = _target(path)
    problem = ""
    if source is not None and target == _target(source):
        problem = "it would replace the recording"
    elif target.is_dir():
        problem = "it is a folder"
    elif not target.parent.exists():
        problem = f"there is no folder '{path.parent}'"
    elif not target.parent.is_dir():
        problem = f"'{path.parent}' is not a folder"
    elif target.exists() and not os.access(target, os.W_OK):
        problem = "the file is read-only"
    elif not is_special(target):
        part = _part(target)
        try:
            part.touch(exist_ok=False)
            part.unlink()
        except OSError as error:
            problem = error.strerror or str(error)
    if problem:
        raise BtManipError(f"{what} '{path}' cannot be written: {problem}")


@contextmanager
def reading(path: str | os.PathLike[str], what: str) -> Iterator[None]:
    """Raise `BtManipError` where the block fails to read a file.

    Args:
        path: The file.
        what: What it should be, the first word of the message: ``"report"``.

    Raises:
        BtManipError: If the file cannot be read, or is something else.
    """
    try:
        yield
    except OSError as error:
        reason = error.strerror or error
        raise BtManipError(f"{what} '{path}' cannot be read: {reason}") from error
    except (ValueError, TypeError, LookupError, EOFError, BadZipFile, RecursionError) as error:
        raise BtManipError(f"'{path}' is not a {what}: {error}") from error


@contextmanager
def writing(path: Path, what: str) -> Iterator[None]:
    """Raise `RecordingError` where the block fails to write a file.

    Args:
        path: The file.
        what: What it is, the first word of the message: ``"report"``.
    """
    try:
        yield
    except OSError as error:
        raise RecordingError(
            f"{what} '{path}' cannot be written: {error.strerror or error}"
        ) from error


@contextmanager
def whole_file(path: Path, *, sync: bool = True) -> Iterator[BinaryIO]:
    """Open a temporary file for writing, and rename it to ``path`` at the end of the block.

    When the block raises, an existing file remains unchanged. Pipes and devices are written
    directly.

    Args:
        path: The file.
        sync: Whether to wait until it is on the disk, so that it survives a crash of the system.
    """
    target = _target(path)
    if is_special(target):
        with target.open("wb") as file:
            yield file
        return
    part = _part(target)
    try:
        with part.open("x+b") as file:  # h5py reads what it writes
            yield file
            file.flush()
            if sync:
                os.fsync(file.fileno())
        part.replace(target)
    except BaseException:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise


class AppendedFile:
    """A new file that grows; what it holds is always a sequence of whole appends."""

    def __init__(self, path: Path) -> None:
        """Create the file, or empty an existing one.

        Raises:
            OSError: If it cannot be opened.
        """
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
        self._file = os.open(path, flags | getattr(os, "O_BINARY", 0), 0o666)
        self.size = 0

    def append(self, data: bytes) -> None:
        """Hand data over to the operating system, so that it survives the end of the process.

        Raises:
            OSError: If it cannot be written; a regular file is then as before.
        """
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[os.write(self._file, rest) :]
        except BaseException:
            with suppress(OSError):  # a pipe or a device
                os.ftruncate(self._file, self.size)
                os.lseek(self._file, self.size, os.SEEK_SET)
            raise
        self.size += len(data)

    def overwrite(self, data: bytes) -> None:
        """Replace the first bytes of a regular file.

        Raises:
            OSError: If that fails.
        """
        os.pwrite(self._file, data, 0)

    def close(self) -> None:
        """Wait until the file is on the disk, and close it.

        Raises:
            OSError: If that fails, or if the file was deleted.
        """
        try:
            if stat.S_ISREG(os.fstat(self._file).st_mode):
                os.fsync(self._file)
                if os.fstat(self._file).st_nlink == 0:
                    raise FileNotFoundError(errno.ENOENT, "it was deleted")
        finally:
            os.close(self._file)


def _target(path: Path) -> Path:
    """Resolve links: the target of a link is replaced, not the link."""
    return Path(os.path.realpath(path))


def _part(target: Path) -> Path:
    return target.with_name(f".{target.name}.{uuid.uuid4().hex[:8]}.part")


def is_special(target: Path) -> bool:
    """Return whether the path is a pipe or device, which cannot be replaced by a file."""
    try:
        mode = target.stat().st_mode
    except OSError:
        return False
    return not stat.S_ISREG(mode) and not stat.S_ISDIR(mode)
