"""The station with two robots, as in the tests of the runner."""

from tests.arm.watch import watch as watch
from tests.runner.conftest import built as built
from tests.runner.conftest import left as left
from tests.runner.conftest import right as right
from tests.runner.conftest import station as station
