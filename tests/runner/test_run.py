"""The loop: cycles, ticks, control steps, observers, and every way in which it ends."""

from functools import partial
from types import SimpleNamespace

import pytest

from bt_manip.bt import (
    Action,
    AlwaysFailure,
    AlwaysSuccess,
    NodeStatus,
    Sequence,
    Sleep,
    Status,
    Tree,
)
from bt_manip.runner import Run, RunModifier, RunObserver, RunRequest, TreeSource
from bt_manip.runner.loop import Pacing

from .conftest import StillCell, still_station


class Log(RunObserver):
    def __init__(self) -> None:
        self.calls = []

    def run_started(self, run):
        self.calls.append("run_started")

    def after_compile(self):
        self.calls.append("after_compile")

    def cycle_started(self, cycle):
        self.calls.append(f"cycle_started {cycle}")

    def after_step(self):
        self.calls.append("step")

    def after_tick(self):
        self.calls.append("after_tick")

    def cycle_ended(self, status, reason):
        self.calls.append(f"cycle_ended {status} {reason}".rstrip())

    def run_ended(self):
        self.calls.append("run_ended")


def make(root, cycles=1, tick=0.002) -> Run:
    station = still_station()
    tree = Tree(root, clock=lambda: station.cell.time)
    return Run(RunRequest(TreeSource("x", "python"), cycles=cycles, tick=tick), tree, station)


def test_observers_are_told_everything_in_order():
    log = Log()
    make(Sleep("rest", msec=3)).execute([log])
    assert log.calls == [
        "run_started", "after_compile", "cycle_started 0",
        "step", "step", "after_tick", "step", "step", "after_tick", "step", "step", "after_tick",
        "cycle_ended SUCCESS", "run_ended",
    ]  # fmt: skip


def test_a_modifier_of_the_run_is_told_after_all_who_watch():
    told, observers = [], [RunModifier(), RunObserver(), RunModifier(), RunObserver()]
    for number, observer in enumerate(observers):
        observer.after_tick = partial(told.append, number)
    make(Sleep("rest", msec=3)).execute(observers)
    assert told[:8] == [1, 3, 0, 2] * 2


@pytest.mark.parametrize(
    ("root", "reason"),
    [
        (Sequence("root", AlwaysFailure("never")), "never:"),
        (Sleep("rest", msec=3, skip_if="true"), "rest: the root was skipped, nothing was done"),
    ],
)
def test_a_failed_cycle_is_told_with_its_reason_and_the_next_one_follows(root, reason):
    log = Log()
    make(root, cycles=2).execute([log])
    ended = [call for call in log.calls if call.startswith("cycle_ended")]
    assert len(ended) == 2
    assert all(call.startswith(f"cycle_ended FAILURE {reason}") for call in ended)


def test_without_an_end_it_goes_on_until_it_is_stopped():
    left, log = iter(range(50)), Log()
    make(AlwaysSuccess(), cycles=0).execute([log], stop=lambda: next(left, None) is None)
    assert len([c for c in log.calls if c.startswith("cycle_started")]) == 51
    assert log.calls[-1] == "run_ended"


@pytest.mark.parametrize(("msec", "cycles"), [(0, 10), (100, 12)])
def test_ten_cycles_in_a_row_that_fail_at_once_end_the_run(msec, cycles):
    log = Log()
    run = make(Sequence("", [Sleep("rest", msec=msec), AlwaysFailure()]), cycles=12)
    run.execute([log])
    assert len([c for c in log.calls if c.startswith("cycle_started")]) == cycles
    early = "10 cycles in a row failed within 0.1 s: AlwaysFailure" in run.ended_early
    assert early == bool(run.ended_early) == (cycles == 10)


def test_stopping_halts_what_runs():
    run, ticks = make(Sequence(Sleep("rest", msec=1000))), iter([False, False, True])
    run.execute(stop=lambda: next(ticks))
    assert run.tree.statuses() == bytes([NodeStatus.IDLE] * 2)


class Brake:
    """An arm that takes a while to come to rest."""

    def __init__(self, cell: StillCell) -> None:
        self._cell, self._rest = cell, 1e9

    @property
    def moving(self) -> bool:
        return self._cell.time < self._rest

    def stop(self) -> None:
        self._rest = self._cell.time + 0.0495


def test_stopping_lets_the_arms_come_to_rest_while_everyone_watches():
    run, log = make(Sleep("rest", msec=1000)), Log()
    arm = Brake(run.station.cell)
    run.station.robots["one"] = SimpleNamespace(arm=arm)
    run.execute([log], stop=lambda: run.station.cell.time >= 0.1)
    assert not arm.moving and run.station.cell.time == pytest.approx(0.15)
    assert log.calls.count("step") == 150
    assert log.calls[-2:] == ["after_tick", "run_ended"]


def test_when_something_raises_everyone_is_told_that_the_run_has_ended():
    class Broken(Log):
        def after_tick(self):
            raise ZeroDivisionError

        def run_ended(self):
            raise KeyError

    log = Log()
    with pytest.raises(KeyError):
        make(AlwaysFailure()).execute([log, Broken()])
    assert log.calls[-1] == "run_ended" and "cycle_ended" not in " ".join(log.calls)


def test_observers_hear_of_a_changed_model_before_the_next_step():
    class Change(Action):
        def update(self):
            run.station.cell.generation += 1
            return Status.SUCCESS

    log, run = Log(), make(Change())
    run.execute([log])
    assert log.calls[2:5] == ["cycle_started 0", "after_compile", "step"]


def test_real_time_waits_for_the_wall_clock_and_a_late_run_does_not_hurry_afterwards(monkeypatch):
    now, slept = [100.0], []

    def sleep(duration: float) -> None:
        slept.append(duration)
        now[0] += duration

    monkeypatch.setattr("bt_manip.runner.loop.time.perf_counter", lambda: now[0])
    monkeypatch.setattr("bt_manip.runner.loop.time.sleep", sleep)
    pacing = Pacing(2.0)
    pacing.start(0.0)
    pacing.wait(0.5)
    pacing.wait(1.0)
    assert slept == pytest.approx([0.25, 0.25])
    now[0] += 5.0
    pacing.wait(2.0)
    pacing.wait(3.0)
    assert slept == pytest.approx([0.25, 0.25, 0.5])
