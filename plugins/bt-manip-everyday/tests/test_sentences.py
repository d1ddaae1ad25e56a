"""Sentences are read, drawn, refused and judged."""

import numpy as np
import pytest

from bt_manip.bt import NodeStatus
from bt_manip.exceptions import BtManipError
from bt_manip.spatial import pose
from bt_manip_everyday import ReadSentence, kinds_in
from bt_manip_everyday.sentences import HoldsExactly

KINDS = ("red_can", "green_can", "blue_can", "bottle", "coffee_mug")


@pytest.mark.parametrize(
    ("sentence", "kinds"),
    [
        ("put the red can into the box", ["red_can"]),
        ("Put the green can, the bottle and the red can into the box.",
         ["green_can", "bottle", "red_can"]),
        ("put all cans into the box", ["blue_can", "green_can", "red_can"]),
        ("put the red can and the red can into the box", ["red_can"]),
    ],
)  # fmt: skip
def test_a_sentence_names_kinds_of_objects_in_its_order(sentence, kinds):
    assert kinds_in(sentence, KINDS) == kinds


@pytest.mark.parametrize(
    ("sentence", "message"),
    [
        ("put the bleu can into the box", "no 'the bleu can'; did you mean 'the blue can'"),
        ("put all plates into the box", "no 'all plates'"),
        ("put red can into the box", "is not understood; say: put the red can"),
        ("drop the red can", "is not understood"),
        ("put the red can into the box and dance", "is not understood"),
        ("", "is not understood"),
    ],
)
def test_what_is_no_sentence_or_names_nothing_is_refused(sentence, message):
    with pytest.raises(BtManipError, match=message):
        kinds_in(sentence, KINDS)


@pytest.mark.start("two cans")
def test_drawn_sentences_name_the_cans_of_the_cell_and_follow_from_the_seed(station, trial):
    drawing = trial(ReadSentence(objects="{objects}", task="{task}"))
    sentences = []
    for _ in range(2):
        station.rng.bit_generator.state = np.random.default_rng(3).bit_generator.state
        found = set()
        for _ in range(20):
            assert drawing.tick() is NodeStatus.SUCCESS
            task, objects = (drawing.blackboard[key] for key in ("task", "objects"))
            assert objects == kinds_in(task, ["red_can", "green_can"])
            found.add(task)
        sentences.append(found)
    one, other = sentences
    assert one == other == {
        "put the red can into the box", "put the green can into the box",
        "put all cans into the box",
    }  # fmt: skip


def test_a_sentence_without_such_objects_in_the_cell_fails(trial):
    assert trial(ReadSentence(objects="{o}", task="{t}")).fails_with("no 'all cans'")


@pytest.mark.start("a can in the box")
def test_a_can_that_falls_into_the_box_is_in_it_too(station, trial):
    condition = HoldsExactly(container="box", objects=["red_can"])
    assert trial(condition).tick() is NodeStatus.SUCCESS
    T_wb = station.cell.pose("box")
    station.cell.move("green_can", pose(T_wb.translation + (0.0, -0.08, 0.06)))
    station.cell.step(5)
    again = HoldsExactly(container="box", objects=["red_can"])
    assert trial(again).fails_with("'green_can' is in it, too")
