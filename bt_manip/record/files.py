"""Writing of files: atomic, or by appending.

A file that grows during a run has an advisory lock (``flock``) while it is open, so that no other
process writes it, too. File systems without such locks, pipes and devices are written unlocked.
"""

import errno
import fcntl
import io
import os
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO
from zipfile import BadZipFile

from bt_manip.exceptions import BtManipError
from bt_manip.files import is_special as is_special
from bt_manip.files import part_of, resolved
from bt_manip.files import whole_file as whole_file

IN_USE = "it is being written"


class RecordingError(BtManipError):
    """A recording that could not be written."""


class FileInUseError(RecordingError):
    """A file that another process is writing."""


def check_writable(path: Path, what: str, *, source: Path | None = None) -> None:
    """Check that a file can be written later, without changing it.

    Args:
        path: The file.
        what: Purpose, the first word of the message: ``"report"``.
        source: The recording that is read, which must be another file.

    Raises:
        BtManipError: When it cannot be written.
    """
    try:
        problem = _problem(path, source)
    except OSError as error:  # such as a name that is too long
        problem = error.strerror or str(error)
    if problem:
        raise BtManipError(f"{what} '{path}' cannot be written: {problem}")


def _problem(path: Path, source: Path | None) -> str:
    """Return why a file cannot be written; empty if it can."""
    target = resolved(path)
    if source is not None and target == resolved(source):
        return "it would replace the recording"
    if target.is_dir():
        return "it is a folder"
    if not target.parent.exists():
        return f"there is no folder '{path.parent}'"
    if not target.parent.is_dir():
        return f"'{path.parent}' is not a folder"
    if target.exists() and not os.access(target, os.W_OK):
        return "the file is read-only"
    if is_locked(target):
        return IN_USE
    if not is_special(target):
        part = part_of(target)
        part.touch(exist_ok=False)
        part.unlink()
    return ""


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


def open_output(path: Path, *, empty: bool = True) -> io.FileIO:
    """Open a file for writing without a buffer, and lock it until it is closed.

    Args:
        path: The file; created if it does not exist.
        empty: Whether an existing file loses its content.

    Raises:
        FileInUseError: If another process has it open for writing.
        OSError: If it cannot be opened.
    """
    if is_special(path):
        return io.FileIO(path, "wb")
    while True:
        file = io.FileIO(os.open(path, os.O_WRONLY | os.O_CREAT, 0o666), "wb")  # truncates nothing
        if not lock(file):
            file.close()
            raise FileInUseError(f"'{path}' cannot be written: {IN_USE}")
        if _is_at(file, path):
            break
        file.close()  # it was deleted or replaced before it was locked
    if empty:
        file.truncate()
    return file


def lock(file: io.FileIO) -> bool:
    """Lock an open file until it is closed; return False if another process has."""
    for wait in (0.02, 0.0):  # a process that asks `is_locked` locks it for microseconds
        try:
            fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            time.sleep(wait)
        except OSError:  # the file system has no locks
            return True
    return False


def check_exists(file: IO[bytes]) -> None:
    """Check that an open file still has a name.

    Raises:
        FileNotFoundError: If it was deleted.
    """
    status = os.fstat(file.fileno())
    if stat.S_ISREG(status.st_mode) and status.st_nlink == 0:
        raise FileNotFoundError(errno.ENOENT, "it was deleted")


def _is_at(file: io.FileIO, path: Path) -> bool:
    try:
        return os.path.samestat(os.stat(path), os.fstat(file.fileno()))
    except FileNotFoundError:
        return False


def is_locked(target: Path) -> bool:
    """Return whether a process is writing a file."""
    if not target.is_file():
        return False
    try:
        with target.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


class AppendedFile:
    """A new file that grows; its content is always a sequence of complete appends.

    Raises:
        OSError: If it cannot be opened, or another process is writing it.
    """

    def __init__(self, path: Path) -> None:
        self._file = open_output(path)
        self.size = 0

    def append(self, data: bytes) -> None:
        """Hand data over to the operating system, so that it survives the end of the process.

        Raises:
            OSError: If it cannot be written; a regular file is then as before.
        """
        rest = memoryview(data)
        try:
            while rest:
                rest = rest[os.write(self._file.fileno(), rest) :]
        except BaseException:
            with suppress(OSError):  # a pipe or a device
                self._file.truncate(self.size)
                self._file.seek(self.size)
            raise
        self.size += len(data)

    def overwrite(self, data: bytes) -> None:
        """Replace the first bytes of a regular file.

        Raises:
            OSError: If that fails.
        """
        os.pwrite(self._file.fileno(), data, 0)

    def sync(self) -> None:
        """Wait until the file is on the disk.

        Raises:
            OSError: If that fails, or if the file was deleted.
        """
        if stat.S_ISREG(os.fstat(self._file.fileno()).st_mode):
            os.fsync(self._file.fileno())
            check_exists(self._file)

    def close(self) -> None:
        """Close the file; other processes may write it now."""
        self._file.close()
