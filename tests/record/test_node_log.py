"""Samples that nodes drew, and retries and rescues, are recorded by the paths of the nodes."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.bt import (
    Action,
    AlwaysFailure,
    AlwaysSuccess,
    Condition,
    Fallback,
    Output,
    ReactiveSequence,
    RetryUntilSuccessful,
    Sequence,
    Sleep,
    Status,
    Timeout,
    Tree,
)
from bt_manip.record.report.node_log import NodeLog


class Fail(Action):
    def __init__(self, times: int, name: str = "fail") -> None:
        super().__init__(name)
        self.times = times

    def update(self) -> Status:
        self.times -= 1
        return Status.FAILURE if self.times >= 0 else Status.SUCCESS


class Is(Condition):
    def __init__(self, *answers: bool) -> None:
        super().__init__("is")
        self.answers = list(answers)

    def update(self) -> Status:
        return Status.SUCCESS if self.answers.pop(0) else Status.FAILURE


class Draw(Action):
    drawn = ("pose", "sizes")
    pose = Output(pin.SE3)
    sizes = Output(list[float])
    other = Output(int)

    def update(self) -> Status:
        yaw = pin.exp3(np.array([0.0, 0.0, 0.5]))
        self.pose, self.sizes, self.other = pin.SE3(yaw, np.array([1.0, 2.0, 3.0])), [0.1, 0.2], 7
        return Status.SUCCESS


def logged(root):
    now = [0.0]
    tree, log = Tree(root, clock=lambda: now[0]), NodeLog()
    tree.observers.append(log)
    while tree.tick().name == "RUNNING":
        now[0] += 0.01
    return log


@pytest.mark.parametrize(
    ("failures", "attempts", "retries"), [(0, 5, {}), (2, 5, {"r": 2}), (9, 3, {"r": 2})]
)
def test_a_child_that_starts_again_after_its_failure_is_a_retry(failures, attempts, retries):
    root = RetryUntilSuccessful("r", Fail(failures), num_attempts=attempts)
    assert logged(root).retries == retries


def test_each_round_of_retries_counts_anew():
    inner = RetryUntilSuccessful("inner", Fail(3), num_attempts=2)
    log = logged(RetryUntilSuccessful("outer", Sequence("s", inner), num_attempts=2))
    assert log.retries == {"outer": 1, "inner": 2}


@pytest.mark.parametrize(
    ("children", "rescues"),
    [
        ([Fail(1), AlwaysSuccess()], {"f": 1}),
        ([Sequence(Is(True), Fail(1)), AlwaysSuccess()], {"f": 1}),
        ([Timeout(Sleep(msec=50), msec=20), Sleep(msec=30)], {"f": 1}),
        ([ReactiveSequence(Is(True, True, False), Sleep(msec=50)), Sleep(msec=30)], {"f": 1}),
        ([Is(False), Fail(1), Fail(0)], {"f": 1}),
        ([Is(False), AlwaysSuccess()], {}),
        ([Sequence(AlwaysSuccess(), Is(False)), Sleep(msec=30)], {}),
        ([AlwaysSuccess(), Fail(1)], {}),
        ([Fail(1), Fail(1)], {}),
    ],
)
def test_a_child_that_succeeds_after_an_action_of_an_earlier_one_failed_rescues(children, rescues):
    log = logged(Sequence("s", Fallback("f", *children)))
    assert (log.rescues, log.retries) == (rescues, {})


def test_a_failure_of_an_earlier_round_rescues_nothing():
    tree = Fallback("f", Fail(1), AlwaysFailure("a", skip_if="true"), Is(False, True))
    assert logged(RetryUntilSuccessful("r", tree, num_attempts=3)).rescues == {}


def test_drawn_outputs_are_kept_by_path_also_if_they_are_connected_to_nothing():
    pose = {"x": 1.0, "y": 2.0, "z": 3.0, "rx": 0.0, "ry": 0.0, "rz": pytest.approx(0.5)}
    log = logged(Sequence("s", Draw("one"), Draw("two", pose="{there}")))
    assert log.drawn == {name: {"pose": pose, "sizes": [0.1, 0.2]} for name in ("one", "two")}
    log.begin()
    assert log.drawn == {} == log.retries == log.rescues
