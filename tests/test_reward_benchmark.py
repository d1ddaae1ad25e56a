"""The dense reward prefers finishing: no way to stall returns as much as the expert."""

import pytest

from benchmarks import bench_rewards
from benchmarks.bench_rewards import returns, tasks


def check(tree):
    found = returns(tree)
    expert = found.pop("expert")
    assert len(found) >= 5
    for name, sums in found.items():
        assert expert[0] > sums[0] and expert[1] > sums[1], f"{tree}: who {name}: {sums}, {expert}"


@pytest.mark.soak
def test_the_expert_returns_more_than_every_way_to_stall(monkeypatch):
    monkeypatch.setattr(bench_rewards, "STEPS", 100)
    check("pick_place")


@pytest.mark.soak
@pytest.mark.parametrize("tree", tasks())
def test_the_expert_of_each_task_returns_more_than_every_way_to_stall(tree):
    check(tree)
