"""Each check of a contract finds what it is there for, and says what it found."""

from functools import cache

import pytest

from bt_manip.robots import panda
from bt_manip_contracts import behaviour_contract as behaviours
from bt_manip_contracts import controller_contract as controllers
from bt_manip_contracts import object_contract as objects
from bt_manip_contracts import robot_contract as robots
from bt_manip_contracts import run_contract as runs
from bt_manip_contracts.behaviour_contract import BehaviourCase, Example
from bt_manip_contracts.controller_contract import ControllerCase
from bt_manip_contracts.object_contract import ObjectCase
from bt_manip_contracts.robot_contract import RobotCase
from bt_manip_contracts.run_contract import RunCase

from . import broken_parts as broken

CUBE = Example({"object": "cube"})


@pytest.mark.parametrize(
    ("check", "cls", "example", "message"),
    [
        (behaviours.setup_starts_nothing, broken.MovesInSetup, Example(), "changes the station"),
        (behaviours.ends_as_it_should, broken.FailsSilently, Example({"object": "x"}),
         "ended with FAILURE"),
        (behaviours.ends_as_it_should, broken.TakesItsTime, Example(),
         "is a Condition and takes 2 ticks"),
        (behaviours.never_steps_the_physics, broken.StepsThePhysics, Example(),
         "tick 1 of StepsThePhysics takes 0.005 s"),
        (behaviours.never_steps_the_physics, broken.PushesThePhysics, Example(),
         "changes the state of the physics"),
        (behaviours.halts_in_every_state, broken.DrivesOn, CUBE, "does not stop the arm"),
        (behaviours.halts_in_every_state, broken.ClosesOn, Example(), "leaves the gripper moving"),
        (behaviours.gives_a_reason_when_it_fails, broken.FailsSilently, CUBE, "without a reason"),
        (behaviours.gives_a_reason_when_it_fails, broken.RaisesInsteadOfFailing, CUBE,
         "raises instead of failing: there is no 'nothing_is_called_so' in the cell"),
        (behaviours.gives_a_reason_when_it_fails, broken.NeverFails,
         Example(fails=({"speed": 0.0},)), "expected FAILURE"),
        (behaviours.runs_the_same_again, broken.Remembers, Example(), "keeps state"),
        (behaviours.runs_the_same_again, broken.RemembersForAll, Example(), "RemembersForAll"),
        (behaviours.goes_on_from_its_state, broken.ForgetsItsState, Example(),
         "continues differently"),
    ],
)  # fmt: skip
def test_a_broken_behaviour_is_found(situations, check, cls, example, message):
    with pytest.raises(AssertionError, match=message):
        check(BehaviourCase(cls, example, situations))


def test_a_behaviour_that_needs_a_cell_to_be_made_is_found(situations):
    with pytest.raises(AttributeError, match="cell"):
        behaviours.needs_no_robot_to_be_built(
            BehaviourCase(broken.AsksTheCellAtOnce, CUBE, situations)
        )


GRIPPER = RobotCase(panda(), broken.ForgetfulGripper)


def thing(name="thing", **parameters):
    return ObjectCase(name, broken.Thing, parameters)


def controller(cls):
    return ControllerCase("broken", cls)


@pytest.mark.parametrize(
    ("check", "case", "message"),
    [
        (robots.its_gripper_continues_from_its_state, GRIPPER, "'panda' does not continue from"),
        (objects.is_stable_at_rest, thing(rest_height=0.03), "does not rest where it was put"),
        (objects.is_stable_at_rest, thing(rest_height=0.033, tilt=0.6), "it moved"),
        (objects.survives_a_fall, thing(rest_height=0.03), "inside the floor"),
        (objects.is_made_again_from_its_parameters, thing(tilt=0.3), "is different"),
        (objects.is_made_again_from_its_parameters, thing("ball"), "calls its kind 'thing'"),
        (controllers.never_gives_nan, controller(broken.Nan), "nan"),
        (controllers.never_gives_nan, controller(broken.TooFew), r"gives \(6,\), expected"),
        (controllers.stays_inside_the_effort_limits, controller(broken.BeyondTheLimits),
         "the limits are"),
        (controllers.is_stable_at_rest, controller(broken.NoGravity), "off after a second at rest"),
        (controllers.returns_from_a_push, controller(broken.Swings), "after a push"),
        (controllers.does_not_chatter, controller(broken.BangBang), "'broken' chatters at rest"),
        (controllers.does_not_chatter, controller(broken.SignOfVelocity), "chatters at rest"),
        (controllers.takes_over_smoothly, controller(broken.Jerks), "of an effort limit"),
    ],
)  # fmt: skip
def test_a_broken_part_is_found(check, case, message):
    with pytest.raises(AssertionError, match=message):
        check(case)


def runs_of(parts, name):
    return RunCase(name, f"{broken.__file__}:{name}", parts)


def test_a_tree_whose_state_is_not_restored_is_found(parts):
    message = r"'forgetful', continued from its state after 6 of 14 ticks, differs from tick 14"
    with pytest.raises(AssertionError, match=message):
        runs.goes_on_from_its_state(runs_of(parts, "forgetful"))


def test_a_tree_whose_episodes_depend_on_others_is_found(parts, monkeypatch):
    monkeypatch.setattr(runs, "EPISODES", 2)
    made = cache(lambda make: make())  # one worker in this process
    monkeypatch.setattr(runs, "run_episodes", lambda make, order, _: map(made(make).run, order))
    with pytest.raises(AssertionError, match=r"the episodes \[0, 1\] of 'counting' differ in rev"):
        runs.has_the_same_episodes_in_any_process(runs_of(parts, "counting"))
    runs.has_the_same_episodes_in_any_process(runs_of(parts, "steady"))
