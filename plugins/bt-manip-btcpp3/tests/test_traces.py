"""Random trees do what the engine 3.8.8 did with them, and so do they as version 4."""

import collections

import pytest

from .engine import cases, converted, run


def test_a_thousand_random_trees_do_what_the_engine_did():
    trees = cases()
    different = [
        tree["seed"]
        for tree in trees
        if run(tree["xml"], len(tree["trace"]), tree["halt"]) != tree["trace"]
    ]
    assert len(trees) == 1000 and not different


@pytest.mark.soak
def test_conversions_without_a_warning_do_the_same_in_version_4(tmp_path):
    count = collections.Counter()
    for tree in cases():
        text, problems = converted(tmp_path / "tree.xml", tree["xml"])
        halts_star = tree["halt"] > 0 and "SequenceStar" in tree["xml"]
        if not problems and not halts_star:
            trace = run(text, len(tree["trace"]), tree["halt"], dialect="btcpp", whole=True)
            count[trace == tree["trace"]] += 1
    assert count[False] == 0 and count[True] > 250
