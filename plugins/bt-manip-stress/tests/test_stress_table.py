"""The table of a stress test."""

from bt_manip.evaluation import WorkerDiedError
from bt_manip_stress import (
    LEGEND,
    StressEpisode,
    StressPhase,
    StressResult,
    StressTable,
    lost_stress,
)

LIFT, DROP = (StressPhase(name, f"pick/{name}", 1.0) for name in ("Lift", "Drop"))
TABLE = StressTable([
    StressResult(StressEpisode("push", LIFT, 0), "recovered"),
    StressResult(StressEpisode("push", DROP, 0), "failed", "Drop: 2.5 N m | pushed"),
    StressResult(StressEpisode("vanish", LIFT, 0), "dishonest", "no cube"),
    StressResult(StressEpisode("vanish", DROP, 0), "none", "no cube"),
    StressResult(StressEpisode("push", LIFT, 1), "failed", "Drop: 3.5 N m | pushed"),
    StressResult(StressEpisode("push", DROP, 1), "hung", "no end", "no home"),
    StressResult(StressEpisode("vanish", LIFT, 1), "dishonest", "no cube"),
    StressResult(StressEpisode("vanish", DROP, 1), "none", "no cube"),
])  # fmt: skip


def test_a_cell_counts_the_seeds_by_outcome():
    assert TABLE.phases == ["Lift", "Drop"]
    assert TABLE.rows() == [["push", "R1 F1", "F1 H1 N1"], ["vanish", "D2", "-"]]
    assert "H: hung (no end within 120 s simulated)" in LEGEND


def test_reasons_that_differ_in_numbers_only_are_one():
    assert TABLE.reasons() == [
        "push F (Drop 1, Lift 1): Drop: 2.5 N m | pushed",
        "vanish D (Lift 2): no cube",
        "push H (Drop 1): no end",
        "push N (Drop 1): no home",
    ]


def test_the_summary_counts_the_faults_that_happened():
    assert TABLE.summary() == (
        "6 faults: 1 recovered, 2 failed, 2 dishonest, 1 hung; 1 undisturbed cycles after them "
        "failed."
    )


def test_the_page_has_the_command_the_table_and_the_reasons():
    lines = TABLE.markdown("bt-manip stress pick_place").splitlines()
    assert lines[0] == "Made by `bt-manip stress pick_place`."
    assert "| push | R1 F1 | F1 H1 N1 |" in lines
    assert "- push F (Drop 1, Lift 1): Drop: 2.5 N m / pushed" in lines


def test_the_page_names_faults_that_cannot_happen_in_a_tree_once():
    never = [
        StressResult(StressEpisode("knock", one, 0), "none", "no cube") for one in (LIFT, DROP)
    ]
    lines = StressTable([*TABLE.results[:2], *never]).markdown("").splitlines()
    assert "Cannot happen in this tree: knock." in lines
    assert [line.split()[1] for line in lines if line[:1] == "|"] == ["fault", "---", "push"]


def test_the_data_have_each_case_with_the_fault_to_repeat_it():
    assert TABLE.plain()[5]["planned"].startswith("push at=pick/Drop after=0.")
    assert TABLE.plain()[5]["planned"].endswith(" cycle=1")


def test_cases_that_were_not_tried_are_not_those_that_cannot_happen():
    episodes = [one.episode for one in TABLE.results]
    table = StressTable([TABLE.results[0], *TABLE.results[3:4]], episodes)
    assert table.phases == TABLE.phases
    assert table.rows() == [["push", "R1 ?1", "?2"], ["vanish", "?2", "- ?1"]]
    assert table.summary().endswith("6 of 8 episodes were not tried (?).")
    assert StressTable([], episodes).rows() == [["push", "?2", "?2"], ["vanish", "?2", "?2"]]


def test_an_episode_whose_process_died_is_an_outcome_of_its_own_and_not_acceptable():
    episode = StressEpisode("vanish", StressPhase("Lift", "t/Lift", 1.0), 0)
    result = lost_stress(episode, WorkerDiedError("its process ended by signal 9"))
    table = StressTable([result])
    assert (result.outcome, result.acceptable) == ("died", False)
    assert table.rows() == [["vanish", "X1"]]
    assert "0 failed, 0 dishonest, 0 hung, 1 died" in table.summary()
    assert table.reasons() == ["vanish X (Lift 1): its process ended by signal 9"]
