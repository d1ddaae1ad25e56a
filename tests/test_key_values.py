"""Parameters as text have the types of their defaults."""

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.key_values import parse_key_values

DEFAULTS = {"camera": "overview", "fps": 25.0, "count": 1, "overlay": False}


def test_values_have_the_types_of_the_defaults():
    words = ["camera=panda/wrist", "fps=30", "count=2", "overlay=yes"]
    values = parse_key_values(words, DEFAULTS, "a video")
    assert values == {"camera": "panda/wrist", "fps": 30.0, "count": 2, "overlay": True}
    assert [type(value) for value in values.values()] == [str, float, int, bool]


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("overlay", "a video: 'overlay' is not KEY=VALUE"),
        ("overlay=1", "a video: overlay is yes or no, got '1'"),
        ("camra=x", "a video has no parameter 'camra'; did you mean 'camera'?"),
        ("count=-1", "a video: count is a whole number of at least 0, got '-1'"),
        ("fps=inf", "a video: fps is a number of at least 0, got 'inf'"),
    ],
)
def test_a_bad_word_is_refused_with_what_is_known(word, message):
    with pytest.raises(BtManipError) as error:
        parse_key_values([word], DEFAULTS, "a video")
    assert str(error.value) == message
