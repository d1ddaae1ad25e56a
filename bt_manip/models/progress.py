"""Telling how far a download is."""

import sys
from collections.abc import Callable

Progress = Callable[[str, int, int], None]
"""Called with the name of what is fetched, the bytes that are here and all of them (0: unknown)."""

_WIDTH = 30


def terminal_progress(name: str, done: int, total: int) -> None:
    """Draw a bar on the terminal, and nothing where there is none."""
    if not sys.stderr.isatty():
        return
    bar = "#" * (_WIDTH * done // total) if total else ""
    size = f"{done / 1e6:.1f}" + (f" of {total / 1e6:.1f}" if total else "")
    end = "\n" if total and done >= total else ""
    sys.stderr.write(f"\r{name} [{bar:{_WIDTH}}] {size} MB{end}")
    sys.stderr.flush()
