"""A parameter is declared once: its type, unit, default, bounds and meaning."""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated

import numpy as np
import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.parameters import MISSING, Parameter, parameters_of, read_words

if TYPE_CHECKING:
    from somewhere import Scene

PARAMETERS = {
    "camera": Parameter("Camera", default="overview"),
    "fps": Parameter("Images per second", "Hz", 25.0, above=0.0, at_most=1000.0),
    "count": Parameter("Number", default=1, at_least=0),
    "overlay": Parameter("Whether it has text", default=False),
}


def test_texts_become_values_of_the_declared_types():
    words = ["camera=panda/wrist", "fps=30", "count=2", "overlay=yes"]
    values = read_words(words, PARAMETERS, "a video")
    assert values == {"camera": "panda/wrist", "fps": 30.0, "count": 2, "overlay": True}
    assert [type(value) for value in values.values()] == [str, float, int, bool]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("overlay", "a video: 'overlay' is not KEY=VALUE"),
        ("overlay=2", "a video: overlay must be true or false, got '2'"),
        ("camra=x", "a video has no parameter 'camra'; did you mean 'camera'?"),
        ("count=-1", "a video: count must be a whole number of at least 0, got '-1'"),
        ("count=1.5", "a video: count must be a whole number of at least 0, got '1.5'"),
        ("fps=inf", "a video: fps must be a number above 0 and at most 1000 [Hz], got 'inf'"),
        ("fps=nan", "a video: fps must be a number above 0 and at most 1000 [Hz], got 'nan'"),
        ("fps=2 fps=3", "a video: 'fps=3' is given twice"),
        ("fps=0", "a video: fps must be a number above 0 and at most 1000 [Hz], got '0'"),
    ],
)
def test_a_bad_word_is_refused_with_type_unit_and_bounds(words, message):
    with pytest.raises(BtManipError) as error:
        read_words(words.split(), PARAMETERS, "a video")
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("declared", "good", "bad", "wanted"),
    [
        (Parameter(default=1.0), [1, -2.5, np.float64(3.0)], [True, "1", math.nan, None, [1.0]],
         "a number"),
        (Parameter(default=1.0, above=0.0, below=180.0), [1e-9, 179.9], [0.0, 180.0, math.inf],
         "a number above 0 and below 180"),
        (Parameter(default=1.0, at_least=0.0, infinite=True), [0.0, math.inf], [-1.0, math.nan],
         "a number of at least 0"),
        (Parameter(default=3, at_least=2, at_most=100), [2, 100, 4.0], [1, 101, 2.5, "3"],
         "a whole number from 2 to 100"),
        (Parameter("Lengths [m]", default=(1.0, 2.0), above=0.0), [[1, 2], np.ones(2)],
         [1.0, [1.0], [1.0, 0.0], [1.0, "x"]], "2 positive numbers [m]"),
        (Parameter("Colour", size=(3, 4), type=float, at_least=0.0, at_most=1.0),
         [(0, 0.5, 1), (0, 0, 0, 1)], [(2, 0, 0), (0, 0), 1.0], "3 or 4 numbers from 0 to 1"),
        (Parameter(default=True), [False], [0, "yes", None], "true or false"),
        (Parameter(default="red"), ["blue"], [3, None], "a text"),
        (Parameter(default=["red", "blue"]), [["green"], ()], ["red", [3]], "a list of texts"),
        (Parameter("Mass", "kg", None, type=float, above=0.0), [None, 1.0], [0.0, "1"],
         "a positive number [kg]"),
    ],
)  # fmt: skip
def test_values_are_checked_by_type_size_and_bounds(declared, good, bad, wanted):
    for value in good:
        declared.check(value)
    assert declared.wanted == wanted
    for value in bad:
        with pytest.raises(ValueError) as error:
            declared.check(value)
        assert str(error.value).startswith(f"must be {wanted}, got ")


def test_the_unit_may_stand_in_the_meaning_or_beside_it():
    apart, inside = Parameter("Force.", "N", 1.0), Parameter("Force [N].", default=1.0)
    assert (apart.unit, inside.unit) == ("N", "N")
    assert apart.described == inside.described == "Force [N]."
    assert Parameter("force", "N").described == "force [N]"


@dataclass
class Fan:
    speed: Annotated[float, Parameter("Speed", "rad/s", at_least=0.0)] = 2
    blades: int = field(default=3, metadata={"": Parameter("Number of blades", at_least=2)})


def fan(path, size: int, *, speed: Annotated[float, Parameter("Speed", "rad/s")] = 2.0, name="a"):
    """Make a fan."""


def test_fields_and_arguments_declare_parameters():
    found = parameters_of(Fan)
    assert found["speed"].line == "speed (number of at least 0, default 2): Speed [rad/s]"
    assert (
        found["blades"].line == "blades (whole number of at least 2, default 3): Number of blades"
    )
    found = parameters_of(fan)
    assert list(found) == ["path", "size", "speed", "name"]
    assert (found["size"].type, found["size"].default, found["name"].type) == (int, MISSING, str)
    assert list(parameters_of(fan, keyword_only=True)) == ["speed", "name"]


def test_annotations_that_only_type_checkers_know_do_not_matter():
    def made(scene: "Scene", speed: float = 1) -> None:
        """Use a scene."""

    assert parameters_of(made)["speed"].default == 1
