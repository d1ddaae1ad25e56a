"""Stops of every kind of motion, in hundreds; it takes minutes."""

import numpy as np
import pytest

from bt_manip.plugins import load_plugins
from tests.measuring.scenes import SCALES
from tests.measuring.stops import measure_stops

pytestmark = pytest.mark.soak
COUNT = 500
# 99th percentile of a stop's duration over the longest time of a joint alone. Where jerk is scarce
# (xArm7), or a joint turns back during a redirected motion (iiwa14), some motions go on to their
# end instead.
SLOWEST = {"xarm7": 4.5, "iiwa14": 6.0}


@pytest.mark.parametrize("name", ["panda", *SCALES])
def test_stops_keep_path_and_limits_and_are_nearly_as_fast_as_the_limits_allow(
    name, request, monkeypatch
):
    if name != "panda":
        pytest.importorskip("bt_manip_menagerie")
        monkeypatch.setenv("MENAGERIE_ROOT", str(request.getfixturevalue("menagerie")))
    stops = measure_stops(COUNT, load_plugins().parts.robots.get(name))
    for stop in stops:
        assert stop.off_path <= 1e-5, stop
        assert stop.limit_use <= 1.0 + 1e-6, stop
        assert stop.duration <= stop.remaining + 1e-9, stop
    ratios = [stop.ratio for stop in stops]
    assert np.median(ratios) <= 1.02
    assert np.percentile(ratios, 99) <= SLOWEST.get(name, 2.5)
