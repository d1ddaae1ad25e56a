"""Which robot can do which task is found before a run."""

from dataclasses import replace

from bt_manip.evaluation import why_not
from bt_manip.robots import panda
from bt_manip.spatial import pose
from tests.support.program import task as task


def test_the_reason_is_what_the_first_motion_or_the_scene_would_fail_for(parts):
    weak = replace(panda(), gripper=replace(panda().gripper, max_force=0.2))
    assert "too little friction to hold 'cube'" in why_not("pick_place", weak, parts, starts=1)
    away = replace(panda(), T_rb=pose((-2.0, 0.0, 0.0)))
    assert "reaches no part of 'table'" in why_not("pick_place", away, parts, starts=1)


def test_the_reason_is_also_what_a_whole_episode_fails_for_if_it_does(parts, task):
    assert why_not("pick_place", "panda", parts, starts=1, episodes=1) == ""
    tree = task('<Sequence><Lift height="0.05"/><AlwaysFailure name="too late"/></Sequence>')
    assert why_not(str(tree), "panda", parts, starts=1) == ""
    assert "too late" in why_not(str(tree), "panda", parts, starts=1, episodes=1)
