"""Episodes run until all are done, or the success rate is known well enough."""

from dataclasses import replace

import pytest

from bt_manip.evaluation import EpisodeResult, evaluate, scheduling
from bt_manip.evaluation.scheduling import MIN_EPISODES


class Coin:
    """A worker whose even episodes succeed at point 0, and all at point 1."""

    def run(self, episode):
        success = episode.point == 1 or episode.episode % 2 == 0
        return EpisodeResult(*episode, 0, success, "SUCCESS" if success else "FAILURE")


@pytest.fixture(autouse=True)
def coins(monkeypatch):
    monkeypatch.setattr(scheduling, "EpisodeWorker", lambda evaluation: Coin())


def count(results):
    points = [result.point for result in results]
    return [points.count(point) for point in range(2)]


def test_a_point_ends_when_its_interval_is_narrow_enough(evaluation):
    two = replace(evaluation(), points=({}, {}))
    assert count(evaluate(two, 300)) == [300, 300]
    some, fewest = count(evaluate(two, 300, until_width=0.15))
    assert fewest == MIN_EPISODES < some < 300
