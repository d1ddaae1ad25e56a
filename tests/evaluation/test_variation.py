"""Parameters are read from text, and varied on a grid or by sampling."""

import pytest

from bt_manip.evaluation import VariedParameter, grid, parse_parameter, parse_point, samples
from bt_manip.exceptions import BtManipError


@pytest.mark.parametrize(
    ("text", "values", "bounds"),
    [
        ("speed=0.5,1.0", (0.5, 1.0), None),
        ("robot=panda, arms/ur5e.toml", ("panda", "arms/ur5e.toml"), None),
        ("colour=[1, 0, 0], [0, 1, 0]", ([1, 0, 0], [0, 1, 0]), None),
        ("kp=100..300:3", (100.0, 200.0, 300.0), (100.0, 300.0)),
        ("kp=-1..1.5", (), (-1.0, 1.5)),
    ],
)
def test_values_and_ranges_are_read(text, values, bounds):
    name = text.partition("=")[0]
    assert parse_parameter(text) == VariedParameter(name, values, bounds)


@pytest.mark.parametrize("text", ["speed", "speed=", "=1", "speed=a..b", "speed=1..2:x"])
def test_other_texts_are_refused(text):
    with pytest.raises(BtManipError, match="--vary"):
        parse_parameter(text)


def test_a_point_has_one_value_of_each_parameter():
    assert parse_point(["speed=0.5", "robot=panda"]) == {"speed": 0.5, "robot": "panda"}
    for text in ("speed=0.5,1.0", "speed=0..1"):
        with pytest.raises(BtManipError, match="--vary speed: a run has one value"):
            parse_point(["robot=panda", text])


def test_a_grid_has_all_combinations():
    points = grid([VariedParameter("a", (1, 2)), VariedParameter("b", ("x", "y", "z"))])
    assert len(points) == 6 and points[1] == {"a": 1, "b": "y"}
    with pytest.raises(BtManipError, match="LOW..HIGH:5; or give --samples"):
        grid([parse_parameter("a=0..1")])


def test_samples_cover_each_range_evenly():
    varied = [parse_parameter("a=5..15"), VariedParameter("b", ("x", "y"))]
    points = samples(varied, 10, seed=3)
    assert sorted(int(point["a"]) for point in points) == list(range(5, 15))
    assert sorted(point["b"] for point in points) == ["x"] * 5 + ["y"] * 5
    assert points == samples(varied, 10, seed=3)
