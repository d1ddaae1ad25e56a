"""Whole trees, headless, judged by the physics at the end of each cycle."""

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.testing import trees_of
from bt_manip.testing.coverage import TreeCoverage
from bt_manip.testing.tree_runs import run_tree

SPAWN = """<root BTCPP_format="4"><BehaviorTree ID="Spawn" _continues="true"><Sequence>
  <SpawnObject region="0.2;0.4;-0.3;0.3" object="{o}"/><Sleep msec="{pause}"/>
</Sequence></BehaviorTree>
<TreeNodesModel><SubTree ID="Spawn"><input_port name="pause" default="20"/></SubTree>
</TreeNodesModel></root>"""

test_built_in_trees_run = trees_of("builtin")


@pytest.fixture
def spawn(tmp_path):
    (tmp_path / "spawn.xml").write_text(SPAWN)
    return "spawn.xml", tmp_path


def test_judging_changes_nothing_even_when_it_lets_time_go_on(parts, spawn):
    tree, folder = spawn
    ends = {True: [], False: []}

    def look(disturb):
        def end_state(station):
            ends[disturb].append(station.cell.state_bytes())
            if disturb:
                station.arm.move_to_configuration(station.arm.q + 0.1)
                station.cell.remove("cube")
                station.rng.uniform()
                station.cell.step(200)

        return end_state

    for disturb in (True, False):
        run_tree(tree, parts, end_state=look(disturb), cycles=3, folder=folder)
    assert len(ends[True]) == 3
    assert ends[True] == ends[False]


def test_every_cycle_that_ends_otherwise_is_listed(parts, spawn):
    tree, folder = spawn

    def at_most_two(station):
        there = [name for name in station.cell.objects if name.startswith("cube")]
        assert len(there) <= 2, f"{len(there)} cubes"

    with pytest.raises(AssertionError) as error:
        run_tree(tree, parts, end_state=at_most_two, cycles=4, folder=folder)
    message = str(error.value)
    assert "2 of 4 cycles of 'spawn.xml' ended as they should" in message
    assert "cycle 2 did not end as it should: 3 cubes" in message
    assert "cycle 3 did not end as it should: 4 cubes" in message


def test_settings_and_seed_reach_the_tree(parts, spawn):
    tree, folder = spawn
    times, places = [], []

    def note(station):
        times.append(round(station.cell.time, 3))
        places.append(tuple(station.cell.pose("cube").translation[:2]))

    for pause, seed in ((20, 1), (50, 1), (20, 2)):
        settings = {"pause": pause}
        run_tree(tree, parts, end_state=note, seed=seed, settings=settings, folder=folder)
    assert times[1] == pytest.approx(times[0] + 0.03)
    assert places[0] == pytest.approx(places[1], abs=1e-4)
    assert places[0] != pytest.approx(places[2], abs=1e-3)
    with pytest.raises(BtManipError, match="has no key 'paus'; did you mean 'pause'"):
        run_tree(tree, parts, settings={"paus": 1}, folder=folder)


def test_runs_of_the_same_tree_add_up_in_its_coverage(parts, tmp_path):
    (tmp_path / "t.xml").write_text(
        """<root BTCPP_format="4"><BehaviorTree ID="T"><Fallback>
        <ObjectExists object="{what}"/><Sleep msec="10"/></Fallback></BehaviorTree>
        <TreeNodesModel><SubTree ID="T"><input_port name="what"/></SubTree>
        </TreeNodesModel></root>"""
    )
    coverage = TreeCoverage()

    def run(what):
        run_tree("t.xml", parts, settings={"what": what}, folder=tmp_path, coverage=coverage)
        return coverage.of("t.xml:T")

    first = run("table")
    assert (first.leaves, first.leaves_all) == (1, 2)
    assert (first.branches, first.branches_all) == (2, 5)  # Sleep has one end only
    assert first.missing == (
        "Fallback::1: never FAILURE", "ObjectExists::2: never FAILURE", "Sleep::3: never ticked",
    )  # fmt: skip
    second = run("ball")
    assert second.leaves == second.leaves_all and second.branches == 4
    assert sum(line.startswith("t.xml:T") for line in coverage.lines()) == 1
