"""The dense reward rises as the task gets done: who is nearer to the goal returns more."""

import pytest

from benchmarks.bench_rewards import curves, tasks

FAST = {"pick_place", "open_drawer"}


@pytest.mark.parametrize(
    "tree",
    [tree if tree in FAST else pytest.param(tree, marks=pytest.mark.soak) for tree in tasks()],
)
def test_who_is_nearer_to_the_goal_returns_more(tree):
    found = curves(tree)
    expert, start = found.pop("expert"), found["waits"].progress[0]
    assert expert.reward == pytest.approx(2.0 - start)
    for name, one in found.items():
        assert all(0.0 <= value < 1.0 for value in one.progress), f"{name} reaches the goal"
        assert one.reward == pytest.approx(one.progress[-1] - start, abs=1e-9)
        assert expert.reward > 1.0 + one.reward, name
    falls = [b - a for a, b in zip(expert.progress, expert.progress[1:], strict=False) if b < a]
    assert -0.05 < sum(falls), "the progress of the expert falls"
    assert found["waits"].reward == pytest.approx(0.0, abs=0.01)
    assert found["hovers"].reward > found["waits"].reward + 0.003  # of nine blocks, one
    if "holds" in found:
        others = {"hovers", "random"} | ({"presses"} if tree != "press_button" else set())
        assert found["holds"].reward > max(found[name].reward for name in others)
    if "knocks off" in found:
        assert found["knocks off"].reward == pytest.approx(-start)
        assert found["knocks off"].reward <= min(one.reward for one in found.values())
