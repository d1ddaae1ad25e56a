"""Tiny worlds for control."""

from tests.support.arms import description as description
from tests.support.arms import make_arm as make_arm
