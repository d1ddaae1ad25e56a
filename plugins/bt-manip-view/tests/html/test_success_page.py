"""The report of an evaluation draws success against each quantity that varied."""

import json

import numpy as np
import pytest

from bt_manip.evaluation import EpisodeResult
from bt_manip.exceptions import BtManipError
from bt_manip_view import results_page
from bt_manip_view.html.success_map import MAP_BINS, cells, map_axes
from bt_manip_view.html.success_page import BINS, quantities, rates_by_value

POINTS = [{"speed": 0.5, "robot": "panda"}, {"speed": 1.0, "robot": "ur5e"}]
IDENTITY = {"tree": "<pick>", "seed": 3, "points": POINTS}


def result(point, episode, mass, success=True):
    cube = {"mass": mass, "size": [0.05, mass]}
    randomized = json.dumps({"objects": {"cube": cube}})
    drawn = json.dumps({"a/Spawn": {"pose": {"x": -mass, "y": 0.5 * mass}}})
    node, reason = ("", "") if success else ("Lift", "<heavy>")
    status = "SUCCESS" if success else "FAILURE"
    return EpisodeResult(
        point, episode, 3, success, status, reason, node, duration_s=2.0, wall_s=0.1,
        randomized=randomized, drawn=drawn,
        rescues=json.dumps({"a/<or>": 2} if episode == 3 else {}),
    )  # fmt: skip


RESULTS = [result(p, n, 0.01 * n, success=n < 10) for p in range(2) for n in range(20)]


def test_varied_parameters_and_samples_are_quantities_if_they_differ():
    found = quantities(POINTS, RESULTS)
    names = "scene.objects.cube.mass", "scene.objects.cube.size[1]"
    drawn = "a/Spawn.pose.x", "a/Spawn.pose.y"
    assert tuple(found) == ("speed", "robot", *drawn, *names)
    assert found[drawn[0]][1] == -0.01
    assert found["robot"] == ["panda"] * 20 + ["ur5e"] * 20


def test_few_values_are_drawn_one_by_one():
    low, high = rates_by_value(quantities(POINTS, RESULTS)["speed"], RESULTS)
    assert (low.x, high.x) == (0.5, 1.0) and low.rate.successes == high.rate.successes == 10


def test_many_numbers_are_drawn_in_bins_of_as_many_episodes():
    rates = rates_by_value(quantities(POINTS, RESULTS)["scene.objects.cube.mass"], RESULTS)
    assert len(rates) == BINS and {one.rate.trials for one in rates} == {5}
    assert np.all(np.diff([one.x for one in rates]) > 0)
    assert [one.rate.successes for one in rates] == [5] * 4 + [0] * 4
    assert rates[0].label == "0 to 0.02"


def test_the_page_loads_nothing_and_escapes_names():
    page = results_page(IDENTITY, RESULTS)
    assert "&lt;pick&gt;" in page and "&lt;heavy&gt;" in page and "<heavy>" not in page
    assert "default-src &#x27;none&#x27;" in page or "default-src 'none'" in page
    assert page.count("success [%]") == 7 and "50.00%" in page
    assert "<td>a/&lt;or&gt;</td><td>rescues</td><td>4</td><td>2</td><td>2</td>" in page


def test_a_map_shows_the_success_rate_over_two_quantities():
    found = quantities(POINTS, RESULTS)
    assert map_axes(found, ()) == ["speed", "a/Spawn.pose.x"]
    drawn = cells(found["speed"], found["scene.objects.cube.mass"], RESULTS)
    assert len(drawn) == 2 * MAP_BINS and {one.rate.trials for one in drawn} == {4}
    assert [one.rate.successes for one in drawn[:5]] == [4, 4, 2, 0, 0]
    assert [(one.left, one.right) for one in drawn[::5]] == [(0.25, 0.75), (0.75, 1.25)]
    bounds = [one.bottom for one in drawn[:5]] + [drawn[4].top]
    np.testing.assert_allclose(bounds, np.quantile([0.01 * n for n in range(20)], np.arange(6) / 5))


def test_the_quantities_of_the_map_can_be_chosen():
    page = results_page(IDENTITY, RESULTS, ("scene.objects.cube.mass", "speed"))
    assert "scene.objects.cube.mass and speed" in page
    with pytest.raises(BtManipError, match="no number that differs .* 'robot'"):
        results_page(IDENTITY, RESULTS, ("speed", "robot"))


def test_an_evaluation_without_results_or_variation_has_a_page():
    assert "succeeded" in results_page({**IDENTITY, "points": [{}]}, [])
    assert "100.00%" in results_page({**IDENTITY, "points": [{}]}, [result(0, 0, 0.1)])
