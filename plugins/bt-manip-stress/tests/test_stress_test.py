"""Each fault at each phase: how a cycle ends is judged by the goal, in the physics."""

from functools import cache, partial

import pytest

from bt_manip.evaluation import run_episodes
from bt_manip_stress import StressEpisode, StressTable, StressTester, plan_episodes, stress_test

TREES = """
from bt_manip.behaviours import ObjectExists, SpawnObject
from bt_manip.bt import Condition, Fallback, Input, Sequence, Sleep, Status, Tree


class IsLight(Condition):
    object = Input(str, doc="Name of the object.")

    def setup(self, **infrastructure):
        self.cell = infrastructure["cell"]

    def update(self):
        if self.cell.overrides.get(self.object):
            return self.fail("it is heavy")
        return Status.SUCCESS


def task(*end):
    spawn, work = SpawnObject(object="{object}"), Sleep("work", msec=300)
    return Tree(Sequence("task", spawn, work, *end), goal=IsLight(object="{object}"))


def trusting():
    return task()


def checking():
    return task(IsLight(object="{object}"))


def waiting():
    return task(Fallback(IsLight(object="{object}"), Sleep("wait", msec=100000)))


def twice():
    return task(Sleep("work", msec=100), Sleep("rest", msec=200))


def empty():
    return Tree(Sleep("work", msec=300), goal=ObjectExists(object="table"))
"""


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """Return what makes the tester of a tree; some notice that their object is heavy."""
    path = tmp_path_factory.mktemp("trees") / "small.py"
    path.write_text(TREES)
    return cache(lambda name: partial(StressTester, f"{path}:{name}"))


@cache
def shared_tester(make):
    """Return the tester that tests of a tree share: building one takes longer than an episode."""
    return make()


def results_of(make, *faults, seeds=1, workers=1):
    episodes = plan_episodes(shared_tester(make), seeds, faults)
    worker = make if workers > 1 else partial(shared_tester, make)
    found = {result.episode: result for result in run_episodes(worker, episodes, workers)}
    return [found[episode] for episode in episodes]


@pytest.mark.parametrize(
    ("name", "fault", "outcome", "acceptable", "reason"),
    [
        ("trusting", "heavy", "dishonest", False, "goal not met: it is heavy"),
        ("checking", "heavy", "failed", True, ": it is heavy"),
        ("checking", "exception", "failed", True, "injected exception"),
        ("checking", "move", "recovered", True, ""),
        ("waiting", "heavy", "hung", False, "no end within 1 s simulated"),
        ("empty", "vanish", "none", True, "there is no object"),
    ],
)
def test_the_goal_judges_a_cycle_with_a_fault_and_the_next_one_succeeds(
    tree, monkeypatch, name, fault, outcome, acceptable, reason
):
    monkeypatch.setattr(stress_test, "TIMEOUT", 1.0)
    (result,) = results_of(tree(name), fault)
    assert (result.outcome, result.acceptable, result.next_reason) == (outcome, acceptable, "")
    assert reason in result.reason


def test_phases_are_the_leaves_that_take_time(tree):
    (phase,) = shared_tester(tree("checking")).phases()
    assert (phase.name, phase.duration) == ("work", 0.3)
    tester = shared_tester(tree("twice"))
    both, rest = tester.phases()  # leaves of one path cannot be told apart
    assert (both.name, both.duration, rest.name, rest.duration) == ("work", 0.4, "rest", 0.2)
    chosen = plan_episodes(tester, 2, ["push", "heavy"], ["rest"])
    assert chosen == [StressEpisode(f, rest, n) for n in (0, 1) for f in ("heavy", "push")]


def test_seeds_begin_faults_at_different_times_in_the_first_half_of_the_phase(tree):
    episodes = plan_episodes(shared_tester(tree("checking")), 100, ["push"])
    begins = [episode.plan().after for episode in episodes]
    assert 0.0 <= min(begins) < 0.01 < 0.14 < max(begins) <= 0.15
    assert begins == [episode.plan().after for episode in episodes]


def test_the_results_do_not_depend_on_the_number_of_processes(tree):
    faults = ("move", "heavy")
    one, two = (results_of(tree("checking"), *faults, workers=workers) for workers in (1, 2))
    assert one == two
    assert StressTable(one).markdown("") == StressTable(two).markdown("")


@pytest.mark.soak
@pytest.mark.parametrize("before", [True, False])
def test_an_episode_of_two_arms_does_not_depend_on_the_one_before(before):
    tester = StressTester("two_arms")
    firsts = "left/the first/OpenGripper", "right/the first/OpenGripper"
    phases = [one for one in tester.phases() if one.path.partition("::")[0] in firsts]
    episodes = [StressEpisode("container_vanishes", phase, 0) for phase in phases]
    assert len(episodes) == 2
    results = [tester.run(episode) for episode in (episodes if before else episodes[1:])]
    for result in results:
        assert (result.outcome, result.next_reason) == ("failed", "")
