"""Let the garbage collector run seldom: its passes over modules and tests take time."""

import gc
import os
from pathlib import Path

GROWTH = 400e6
"""Memory that may grow until what tests have left in cycles is collected, such as stations [B]."""

STATM = Path("/proc/self/statm")

gc.disable()  # until all tests are collected


def pytest_collection_finish() -> None:
    """Spare the garbage collector the modules and tests."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    gc.enable()


def memory() -> int:
    """Return the resident memory of this process, as far as it is known [B]."""
    return int(STATM.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") if STATM.exists() else 0


_kept = memory()


def pytest_runtest_logfinish() -> None:
    """Collect garbage once it takes much memory: each station of 10 MB is a cycle."""
    global _kept
    if memory() > _kept + GROWTH:
        gc.collect()
        _kept = memory()


def pytest_unconfigure() -> None:
    """Leave nothing for the end of Python, when libraries report it as leaked."""
    gc.unfreeze()
    gc.collect()
