"""Tiny worlds for control, which tests of packages share."""

from tests.support.arms import Wave as Wave
from tests.support.arms import description as description
from tests.support.arms import make_arm as make_arm
from tests.support.arms import panda_cell as panda_cell
