"""Success rates come with Wilson intervals, and failures are counted by node and reason."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from bt_manip.evaluation import EpisodeResult, SuccessRate, wilson_interval


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [  # R: binom::binom.confint(x, n, methods = "wilson")
        (0, 10, 0.0, 0.277533), (5, 10, 0.236593, 0.763407), (10, 10, 0.722467, 1.0),
        (190, 200, 0.910421, 0.972599), (0, 0, 0.0, 1.0),
    ],
)  # fmt: skip
def test_the_interval_is_wilsons(successes, trials, low, high):
    assert wilson_interval(successes, trials) == pytest.approx((low, high), abs=1e-4)


def result(episode, node="", reason=""):
    return EpisodeResult(0, episode, 0, not node, "FAILURE" if node else "SUCCESS", reason, node)


def test_failures_are_one_if_they_differ_in_numbers_only_and_lost_episodes_are_said():
    rate = SuccessRate.of(
        [
            result(7, "Lift", "the payload weighs 1.6 kg"), result(1), result(2, "Drop", "lost"),
            result(4, "Lift", "the payload weighs 0.9 kg"), result(5),
        ]
    )  # fmt: skip
    lift, drop = rate.failures()
    assert (lift.node, lift.count, lift.first) == ("Lift", 2, 4)
    assert lift.reason == "the payload weighs 0.9 kg" and (drop.node, drop.count) == ("Drop", 1)
    assert str(rate) == "2 of 5 episodes succeeded: 40.00% (95 %: 11.76% to 76.93%)"
    for status in ("DIED", "UNSTARTED"):
        rate.add(EpisodeResult(0, 6, 0, False, status))
    assert str(rate).startswith("2 of 7 ") and str(rate).endswith("%), 2 had no outcome")


def test_results_have_a_mean_with_its_interval_and_recoveries_are_counted_by_node():
    lifted, weights = [0.2, 0.5, 0.15, 0.9], [{"weight": 2}, {}, {"weight": "?"}, {}]
    nodes = [{"a": 2, "z": 1}, {"b": 1}, {"z": 4}, {}]
    rate = SuccessRate.of(
        replace(one, results=json.dumps({"lifted": height, **weight}), retries=json.dumps(retries))
        for one, height, weight, retries in zip(
            (result(0), result(1, "Lift"), result(2, "Lift"), result(3)),
            lifted, weights, nodes, strict=True,
        )
    )  # fmt: skip
    lift, weight = rate.results()
    half = norm.ppf(0.975) * np.std(lifted, ddof=1) / 2.0
    assert (lift.key, lift.episodes) == ("lifted", 4)
    assert (lift.mean, lift.half_width) == pytest.approx((np.mean(lifted), half))
    assert str(lift) == "lifted: 0.438 on average (95 %: 0.0995 to 0.775), in 4 episodes"
    assert str(weight) == "weight: 2 on average, in 1 episodes"
    again = [("z", "retries", 5, 2, 1), ("a", "retries", 2, 1, 1), ("b", "retries", 1, 1, 0)]
    assert rate.recoveries() == again
