"""What the tests share: the program, run inside the test's own process."""

from tests.support.program import bt_manip as bt_manip
