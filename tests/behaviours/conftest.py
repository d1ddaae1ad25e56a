"""Start situations by the names of fixtures."""

import pytest


@pytest.fixture
def at_the_cube(station, situations):
    return situations.reset("around the cube")


@pytest.fixture
def with_the_cube(station, situations):
    return situations.reset("holding a cube over the table")
