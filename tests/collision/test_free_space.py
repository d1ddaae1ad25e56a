"""Free space of one motion: clearances, and escaping from contacts at the start."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.collision import PADDING, FreeSpace
from bt_manip.exceptions import MotionError
from bt_manip.robots import panda

HOME = np.array(panda().home)


def test_it_keeps_a_clearance_except_from_bodies_nearer_at_the_start_or_end(walled):
    def at(gap):
        T = spatial.pointing_down((0.5, 0.3, 0.0095 + gap), 0.0)
        return walled.ik.solve(T, HOME).q

    space = FreeSpace(walled.world, HOME, clearance=5e-3)
    assert space.is_free(HOME)
    assert space.is_free(at(6e-3)) and not space.is_free(at(3e-3))
    usual = FreeSpace(walled.world, HOME)
    assert usual.is_free(at(4.5e-3)) and not usual.is_free(at(3.5e-3))
    assert usual.clearance[walled.world.self_pairs].max() == 1e-3
    for start, ends in ((HOME, [at(2e-3)]), (at(2e-3), [])):
        space = FreeSpace(walled.world, start, ends, clearance=5e-3)
        assert space.is_free(at(2e-3)) and space.is_free(at(3e-3)) and not space.is_free(at(1e-3))


def test_a_contact_at_the_start_may_be_left_but_not_deepened(walled):
    def at(height):
        T = spatial.pointing_down((0.5, 0.3, 0.0095 + height), 0.0)
        return walled.ik.solve(T, walled.ik.solve(walled.left, HOME).q).q

    space = FreeSpace(walled.world, at(-3e-3))
    assert space.is_free(at(-2e-3)) and space.is_free(at(20e-3))
    assert not space.is_free(at(-6e-3))
    for aside, free in ((0.035, True), (0.055, False)):  # still in contact, how far from the start
        beside = at(-3e-3) + aside * np.eye(7)[0]
        assert walled.world.collisions(beside) and space.is_free(beside) is free


def test_a_clearance_beyond_the_padding_is_refused(walled):
    with pytest.raises(MotionError, match=r"clearance must be at most 0\.008 \[m\], got 0\.01"):
        FreeSpace(walled.world, HOME, clearance=0.01)
    FreeSpace(walled.world, HOME, clearance=PADDING)
