"""Switching downloads off."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from bt_manip.models.errors import ModelError

_reason: ContextVar[str] = ContextVar("why nothing may be downloaded; empty: it may", default="")


@contextmanager
def no_downloads(reason: str) -> Iterator[None]:
    """Refuse the download of models inside the block; those in the cache are found.

    Args:
        reason: Why, for the message: ``a snapshot downloads nothing``.
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
