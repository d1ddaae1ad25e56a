"""A disk that becomes full."""

import resource
from collections.abc import Callable, Generator

import pytest

BEFORE = resource.getrlimit(resource.RLIMIT_FSIZE)


@pytest.fixture
def file_size_limit() -> Callable[[int], None]:
    """Limit the size of files [bytes]: a write beyond it fails as on a full disk."""
    return lambda size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, BEFORE[1]))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call() -> Generator[None, object, object]:
    """Remove the limit before pytest prints the result, perhaps to a file."""
    try:
        return (yield)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, BEFORE)
