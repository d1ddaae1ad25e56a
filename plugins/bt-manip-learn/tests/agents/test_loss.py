"""An object of the goal is lost when no robot can reach it any more."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.runner import request_of
from bt_manip_learn.agents import Episodes
from bt_manip_learn.agents.progress import LossCheck


@pytest.fixture(scope="module")
def episodes(parts):
    return Episodes(request_of("pick_place", parts), parts)


def put(episodes, position) -> None:
    episodes.station.cell.move("cube", spatial.pose(position), overlap=9.0)


def test_an_object_beyond_the_stretched_arm_is_lost(episodes):
    episodes.reset(0)
    loss = LossCheck(episodes)
    model = episodes.station.arm.model
    assert loss.reason() == ""
    # The farthest tool position from the shoulder, over random configurations.
    rng = np.random.default_rng(0)
    lower, upper = model.limits.sampling_bounds()
    shoulder = model.model.jointPlacements[1].translation
    tools = [model.pose(q).translation for q in rng.uniform(lower, upper, (2000, model.nq))]
    reached = max(tools, key=lambda tool: np.linalg.norm(tool - shoulder))
    put(episodes, reached)
    assert loss.reason() == ""
    put(episodes, shoulder + 1.6 * (reached - shoulder))
    assert loss.reason() == "'cube' is out of reach"


def test_an_object_below_everything_has_fallen(episodes):
    episodes.reset(1)
    loss = LossCheck(episodes)
    cell = episodes.station.cell
    x, y, _ = cell.pose("cube").translation
    lowest = min(cell.pose(name).translation[2] for name in ("cube", "basket", "panda"))
    put(episodes, (x, y, lowest - 0.11))
    assert loss.reason() == "'cube' has fallen"
    put(episodes, (x, y, lowest - 0.09))
    assert loss.reason() == ""
