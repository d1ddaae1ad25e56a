"""Overlapping predictions are averaged as in Action Chunking with Transformers."""

import math

import pytest

from bt_manip_policy.ensembling import ensembled, older


def test_the_oldest_prediction_weighs_most():
    chunks = [(2, [[9.0], [9.0], [1.0]]), (1, [[9.0], [2.0]]), (0, [[4.0]])]
    w = [1.0, math.exp(-0.5), math.exp(-1.0)]
    expected = (1.0 * w[0] + 2.0 * w[1] + 4.0 * w[2]) / sum(w)
    assert ensembled(chunks, 0.5) == pytest.approx([expected])
    assert ensembled(chunks, 0.0) == pytest.approx([7.0 / 3.0])


def test_predictions_that_do_not_reach_the_present_step_are_left_out():
    chunks = older([(1, [[1.0], [1.0]]), (0, [[2.0], [2.0]])])
    assert chunks == [(1, [[2.0], [2.0]])]
    assert ensembled([*chunks, (0, [[4.0]])], 0.0) == [3.0]
