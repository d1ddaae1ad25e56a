"""The station with two robots, as in the tests of the runner."""

from tests.runner.conftest import left as left
from tests.runner.conftest import parts as parts
from tests.runner.conftest import right as right
from tests.runner.conftest import station as station
from tests.runner.conftest import two_robots as two_robots
