"""Faults as text."""

import math

import pytest

from bt_manip.bt import Sequence, Sleep, Tree
from bt_manip.exceptions import BtManipError
from bt_manip.parameters import parameters_of
from bt_manip_stress import FaultError, PlannedFault, parse_fault


def test_a_text_names_a_fault_its_node_and_its_parameters(parts):
    planned = parse_fault("push at=Lift after=0.2 cycle=2 force=80 link=link4", parts.of("faults"))
    assert planned == PlannedFault(
        "push", "Lift", after=0.2, cycle=2, parameters={"force": 80.0, "link": "link4"}
    )
    assert planned.make(parts.of("faults")).force == 80.0
    assert parse_fault(str(planned), parts.of("faults")) == planned


DEFAULTS = {
    "vanish": {}, "move": {"distance": 0.1}, "knock": {"distance": 0.1},
    "slippery": {"friction": 0.003}, "heavy": {"mass": 10.0}, "stuck": {"duration": 1.0},
    "obstacle": {"width": 0.06, "height": 0.3, "distance": 0.15, "clearance": 0.1},
    "container_vanishes": {}, "push": {"force": 100.0, "duration": 2.0},
    "stuck_joint": {"joint": 0, "duration": 1.0}, "stuck_finger": {"finger": 0, "duration": 1.0},
    "torque_loss": {"duration": 0.2}, "sensor_noise": {"position": 2e-5, "velocity": 2e-3},
    "sensor_delay": {"delay": 0.002}, "sensor_nan": {"joint": 0, "duration": 0.01},
    "exception": {}, "tick_delay": {"duration": 0.5},
}  # fmt: skip
"""Numbers of the faults of docs/stress_tables.md."""


def test_faults_without_parameters_are_those_of_the_published_tables(parts):
    faults = parts.of("faults")
    for name, numbers in DEFAULTS.items():
        shown = {key: one.default for key, one in parameters_of(faults.get(name)).items()}
        assert {key: n for key, n in shown.items() if n not in ("", math.inf)} == numbers


def test_names_with_spaces_are_quoted_and_a_duration_may_be_infinite(parts):
    planned = parse_fault("push at='pick and place' duration=inf", parts.of("faults"))
    assert planned.at == "pick and place"
    assert planned.make(parts.of("faults")).duration == math.inf


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "a fault is NAME at=NODE KEY=VALUE ..., got ''"),
        ("push at='Lift", "got 'push at='Lift': No closing quotation"),
        ("pusch at=Lift", "unknown fault 'pusch'; did you mean 'push'?"),
        ("push", "fault 'push' needs at=NODE, the node at whose start it begins"),
        ("push at=Lift hard", "fault 'push': 'hard' is not KEY=VALUE"),
        ("push at=Lift force=1 force=2", "fault 'push': 'force=2' is given twice"),
        ("push at=Lift forse=1", "fault 'push' has no parameter 'forse'; did you mean 'force'?"),
        ("push at=Lift force=x", "fault 'push': force must be a number of at least 0 [N], got 'x'"),
        ("push at=Lift force=nan", "must be a number of at least 0 [N], got 'nan'"),
        ("push at=Lift force=inf", "must be a number of at least 0 [N], got 'inf'"),
        ("push at=Lift duration=-1", "duration must be a number of at least 0 [s], got '-1'"),
        ("stuck_joint at=Lift joint=2.5", "joint must be a whole number of at least 0, got '2.5'"),
    ],
)
def test_a_bad_text_is_refused_with_what_is_known(parts, text, message):
    with pytest.raises(BtManipError) as error:
        parse_fault(text, parts.of("faults"))
    assert message in str(error.value)


def test_a_node_is_found_by_path_name_or_registered_name():
    tree = Tree(Sequence("all", [Sleep("first", msec=1), Sleep("second", msec=1)]))
    assert [n.name for n in PlannedFault("push", "first").nodes(tree)] == ["first"]
    assert [n.name for n in PlannedFault("push", "Sleep").nodes(tree)] == ["first", "second"]
    with pytest.raises(FaultError, match="fault 'push': the tree has no node 'frist'; did you"):
        PlannedFault("push", "frist").nodes(tree)
