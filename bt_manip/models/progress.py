"""Progress of downloads."""

import sys
from collections.abc import Callable

Progress = Callable[[str, int, int], None]
"""Called with the name of a download, its received bytes and its size (0: unknown)."""

_WIDTH = 30


def terminal_progress(name: str, done: int, total: int) -> None:
    """Draw a progress bar if the standard error is a terminal."""
    if not sys.stderr.isatty():
        return
    bar = "#" * (_WIDTH * done // total) if total else ""
    size = f"{done / 1e6:.1f}" + (f" of {total / 1e6:.1f}" if total else "")
    end = "\n" if total and done >= total else ""
    sys.stderr.write(f"\r{name} [{bar:{_WIDTH}}] {size} MB{end}")
    sys.stderr.flush()
