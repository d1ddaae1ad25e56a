"""Episodes run until all are done, or the success rate is known well enough."""

from collections import Counter
from dataclasses import replace

from bt_manip.evaluation import EpisodeResult, evaluate, scheduling
from bt_manip.evaluation.scheduling import MIN_EPISODES


class Coin:
    """A worker whose even episodes succeed at point 0, and all at point 1."""

    def run(self, episode):
        success = episode.point == 1 or episode.episode % 2 == 0
        return EpisodeResult(*episode, 0, success, "SUCCESS" if success else "FAILURE")


def test_a_point_ends_when_its_interval_is_narrow_enough(evaluation, monkeypatch):
    monkeypatch.setattr(scheduling, "EpisodeWorker", lambda evaluation: Coin())
    two = replace(evaluation(), points=({}, {}))
    assert Counter(one.point for one in evaluate(two, 300)) == {0: 300, 1: 300}
    some, fewest = Counter(one.point for one in evaluate(two, 300, until_width=0.15)).values()
    assert fewest == MIN_EPISODES < some < 300
