"""Kinds of actions keep their contract, which finds those that do not."""

from dataclasses import replace

import numpy as np
import pytest

from bt_manip_contracts import contracts_of
from bt_manip_learn import environment_contract as environments
from bt_manip_learn.agents import JointTargets
from bt_manip_learn.environment_contract import EnvironmentCase

test_contracts = contracts_of("learn")


class Tires(JointTargets):
    """Move less from step to step, over the ends of episodes, and keep no state of it."""

    kind = "tires"
    strength = 1.0

    def command(self, action):
        self.strength *= 0.9
        super().command(np.asarray(action) * self.strength)


def described(**changes):
    """Make joint targets with another description."""

    def make(episodes):
        kind = JointTargets(episodes)
        kind.space = kind.space._replace(**changes)
        return kind

    return make


@pytest.mark.parametrize(
    ("check", "make", "message"),
    [
        (environments.describes_its_actions, described(high=np.full(8, np.inf)), "has the bounds"),
        (environments.describes_its_actions, described(names=("target",)), "1 names and 8 units"),
        (environments.describes_its_actions, described(units=("rad",)), "8 names and 1 units"),
        (environments.goes_on_from_its_state, Tires,
         "the same environment of 'pick_place' continues differently from its state after actions"),
        (environments.has_the_same_episodes_in_any_order, Tires,
         "episode 0 of 'pick_place' depends on those before it"),
    ],
)  # fmt: skip
def test_a_broken_kind_of_actions_is_found(parts, check, make, message):
    parts = replace(parts, declared={"actions": parts.of("actions").with_part("broken", make)})
    with pytest.raises(AssertionError, match=message):
        check(EnvironmentCase("broken", parts))


def test_kinds_of_actions_and_trees_of_any_plugin_are_checked(parts):
    provides = {"actions": ("targets",), "trees": ("rest",)}
    checks = {one.id: one.long for one in environments.environment_checks(parts, provides, {})}
    actions = [f"targets: {one.__name__}" for one in environments.ACTION_CONTRACT]
    tree = "tree rest: environments go on from their states with "
    assert checks == {one.replace("_", " "): False for one in actions} | {
        f"{tree}{kind}": True for kind in parts.of("actions")
    }
