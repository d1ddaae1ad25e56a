"""Standard streams that do not end a run."""

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import click


class UnfailingFile(io.FileIO):
    """A stream that drops everything after the first write that failed, of which it may warn."""

    warns = False

    def write(self, data: Any) -> int:
        """Write data, or drop it: a pipe without a reader, a full disk, a closed terminal."""
        size = memoryview(data).nbytes
        try:
            written = super().write(data)
        except OSError as error:
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, self.fileno())
            os.close(null)
            if self.warns:
                text = f"standard output: {error.strerror}; nothing more is printed there"
                click.echo(f"Warning: {text}", err=True)
            return size
        return size if written is None else written  # None: a pipe that is full and does not block


def echo_wrapped(line: str) -> None:
    """Print a line; a terminal gets it wrapped between words, a pipe whole."""
    if not sys.stdout.isatty():
        click.echo(line)
        return
    from rich.console import Console

    from bt_manip.viewer import print_wrapped

    print_wrapped(Console(), line, indent=4)


@contextmanager
def unfailing(*names: str) -> Iterator[None]:
    """Keep writing to ``stdout`` or ``stderr`` from raising; unencodable characters are escaped."""
    before = {name: stream for name in names if (stream := getattr(sys, name)) is not None}
    for name, stream in before.items():
        setattr(sys, name, _unfailing(stream, warns=name == "stdout"))
    try:
        yield
    finally:
        for name, stream in before.items():
            getattr(sys, name).flush()
            setattr(sys, name, stream)


def _unfailing(stream: Any, *, warns: bool) -> Any:
    try:
        file = UnfailingFile(stream.fileno(), "w", closefd=False)
    except (OSError, ValueError):  # in memory, or closed
        return stream
    file.warns = warns
    with suppress(OSError):
        stream.flush()
    return io.TextIOWrapper(
        io.BufferedWriter(file),
        encoding=stream.encoding,
        errors="backslashreplace",
        line_buffering=stream.line_buffering,
    )


def open_closed_streams() -> None:
    """Open standard streams that are closed as the null device.

    Otherwise the next file that is opened, such as a report, gets the number of a standard stream.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest free number
    for name, number in (("stdout", 1), ("stderr", 2)):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w", closefd=False))
