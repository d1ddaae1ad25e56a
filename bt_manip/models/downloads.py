"""Downloads of models, and caches of sources."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from bt_manip.models.errors import ModelError

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


_reason: ContextVar[str] = ContextVar("why nothing may be downloaded; empty: it may", default="")


@contextmanager
def no_downloads(reason: str) -> Iterator[None]:
    """Reject downloads of models inside the block for a reason; cached models are available.

    It begins the message: ``a snapshot downloads nothing``.
    """
    token = _reason.set(reason)
    try:
        yield
    finally:
        _reason.reset(token)


def check_downloads(address: str) -> None:
    """Check that a model may be downloaded.

    Raises:
        ModelError: Inside `no_downloads`.
    """
    if _reason.get():
        raise ModelError(f"{_reason.get()}; 'bt-manip models fetch {address}' does")


class ModelCache:
    """Cached models of a source, for the commands of ``bt-manip models``.

    Attributes:
        kinds: Kinds of addresses of its models: ``("fuel", "https")``.
    """

    kinds: tuple[str, ...] = ()

    def addresses(self, everything: bool) -> Iterable[str]:
        """Return the addresses of the cached models.

        Args:
            everything: Whether to add known models that would be downloaded, with the suffix ``"
                *"``.
        """
        raise NotImplementedError

    def fetch(self, address: str) -> tuple[str, Path]:
        """Download a model, or a newer version of it; return its exact address and its path.

        Raises:
            ModelError: If it cannot be fetched.
        """
        raise NotImplementedError

    def remove(self, address: str) -> list[Path]:
        """Delete a model; return the deleted paths.

        Raises:
            ModelError: If there is no such model.
        """
        raise NotImplementedError

    def clear(self) -> list[Path]:
        """Delete all models; return the deleted paths."""
        return [path for address in list(self.addresses(False)) for path in self.remove(address)]
