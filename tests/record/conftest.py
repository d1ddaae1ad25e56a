"""A disk that becomes full."""

from tests.support.file_size import file_size_limit as file_size_limit
from tests.support.file_size import pytest_runtest_call as pytest_runtest_call
