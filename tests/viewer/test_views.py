"""Views show a run and leave the terminal as they found it."""

import io
import re
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console

from bt_manip.bt import (
    Action,
    Condition,
    Fallback,
    ReactiveSequence,
    ScriptCondition,
    Sequence,
    Status,
    Tree,
)
from bt_manip.runner.observer import RunObserver
from bt_manip.runner.request import RunRequest
from bt_manip.runner.tree_source import TreeSource
from bt_manip.viewer.plain_view import PlainView
from bt_manip.viewer.terminal_view import TerminalView

HIDE, SHOW = "\x1b[?25l", "\x1b[?25h"


class Step(Action):
    """Run for a tick, then end as it is told."""

    result = Status.SUCCESS

    def initialise(self) -> None:
        self.first = True

    def update(self) -> Status:
        first, self.first = self.first, False
        self.feedback_message = "half way" if first else "all the way"
        if first:
            return Status.RUNNING
        return self.result if self.result is Status.SUCCESS else self.fail("it slipped")


class Slip(Step):
    result = Status.FAILURE


@pytest.fixture
def watch():
    """Run a tree without any cell under a view; give what is on the screen."""

    def run(
        view_of: Any, *leaves: Any, terminal: bool, cycles: int = 1, width: int = 80,
        robots: tuple[str, ...] = ("panda",),
    ) -> str:  # fmt: skip
        out = io.StringIO()
        console = Console(file=out, force_terminal=terminal, width=width, height=12)
        view: RunObserver = view_of(console, cycles=cycles)
        cell = SimpleNamespace(time=0.0)
        tree = Tree(Sequence("all", list(leaves)), clock=lambda: cell.time)
        request = RunRequest(TreeSource("task", "python"), cycles=cycles)
        station = SimpleNamespace(cell=cell, robots=robots)
        view.run_started(SimpleNamespace(request=request, tree=tree, station=station))
        for cycle in range(cycles):
            view.cycle_started(cycle)
            status = Status.RUNNING
            while status.name == "RUNNING":
                status = tree.tick()
                cell.time += 0.01
                view.after_tick()
            reason = tree.failure_reason() if status.name == "FAILURE" else ""
            view.cycle_ended(status.name, reason)
        view.run_ended()
        return out.getvalue()

    return run


@pytest.fixture(autouse=True)
def draw_every_tick(monkeypatch):
    monkeypatch.setattr("bt_manip.viewer.terminal_view.REDRAW", 0.0)


def test_the_terminal_shows_tree_cycle_phase_and_pace(watch):
    shown = watch(TerminalView, Step("reach"), Step("grasp"), terminal=True, cycles=2)
    for text in ("task", "cycle 2/2", "grasp", "half way", "real time", "▶", "✓"):
        assert text in shown
    assert HIDE in shown and shown.rfind(SHOW) > shown.rfind(HIDE)


@pytest.mark.parametrize("width", [60, 80])
@pytest.mark.parametrize(("view", "terminal"), [(PlainView, False), (TerminalView, True)])
def test_several_cycles_show_success_rate_and_time_left(watch, monkeypatch, view, terminal, width):
    monkeypatch.setenv("NO_COLOR", "1")
    shown = watch(view, Step("reach"), terminal=terminal, cycles=3, width=width)
    words = " ".join(shown.split())
    assert "1 of 1 cycles succeeded, about 0 s left" in words
    assert "2 of 2 cycles succeeded, about 0 s left" in words
    assert not re.search(r"\x1b\[[0-9;]*3\dm", shown)
    assert max(map(len, re.sub(r"\x1b\[[0-9;?]*\w", "", shown).splitlines())) <= width
    assert "succeeded" not in watch(view, Step("reach"), terminal=terminal, width=width)


def test_a_tree_higher_than_the_screen_is_shown_around_what_runs(watch):
    leaves = [Step(f"leaf{i:02}") for i in range(40)]
    shown = watch(TerminalView, *leaves, terminal=True)
    pictures = [p for p in shown.split("cycle 1/1") if "leaf39" in p.splitlines()[0]]
    assert pictures
    for picture in pictures:
        assert "Sequence" in picture and "leaf38" in picture and "leaf00" not in picture


def test_without_a_terminal_each_phase_is_a_line(watch):
    lines = watch(PlainView, Step("reach"), Slip("grasp"), terminal=False).splitlines()
    assert [line.split()[2:4] for line in lines[:2]] == [
        ["SUCCESS", "reach:"],
        ["FAILURE", "grasp:"],
    ]
    assert lines[2].startswith("cycle 1/1: FAILURE after 0.03 s")
    assert "it slipped" in lines[2]
    assert "\x1b" not in "".join(lines)


def test_a_condition_that_is_checked_at_every_tick_is_one_line_until_it_changes(watch):
    tree = ReactiveSequence("while", ScriptCondition("clear", code="true"), Step("reach"))
    lines = watch(
        PlainView, tree, ScriptCondition("clear", code="true"), terminal=False
    ).splitlines()
    assert [line.split()[2:4] for line in lines[:-1]] == [
        ["yes", "clear"],
        ["SUCCESS", "reach:"],
        ["yes", "clear"],
    ]


def test_with_many_cycles_each_cycle_is_a_line(watch):
    lines = watch(PlainView, Step("reach"), terminal=False, cycles=3).splitlines()
    assert [line.split(":")[0] for line in lines] == ["cycle 1/3", "cycle 2/3", "cycle 3/3"]


@pytest.mark.parametrize(("view", "terminal"), [(PlainView, False), (TerminalView, True)])
def test_long_reasons_are_wrapped_between_words(watch, monkeypatch, view, terminal):
    monkeypatch.setattr("bt_manip.viewer.terminal_view.REDRAW", 1e9)
    shown = watch(view, Slip("grasp " * 30), terminal=terminal, width=40)
    lines = re.sub(r"\x1b\[[0-9;?]*\w", "", shown).splitlines()
    assert max(map(len, lines)) <= 40
    assert " ".join(shown.split()).count("grasp") >= 30
    assert "gras\n" not in shown


class Question(Condition):
    def update(self) -> Status:
        return self.fail("it is empty")


@pytest.mark.parametrize("view", [PlainView, TerminalView])
def test_leaves_and_answers_of_cycles_that_failed_stay_on_the_screen(watch, view):
    leaves = Fallback("else", [Question("asked"), Step("reach")]), Slip("grasp")
    shown = watch(view, *leaves, terminal=view is TerminalView, cycles=2)
    assert re.search(r"0\.00 s  no +asked: it is empty", shown)
    assert not re.search(r"(FAILURE|✗) +asked", shown)
    assert len(re.findall(r"SUCCESS  reach: all the way", shown)) == 2
    assert len(re.findall(r"FAILURE  grasp: it slipped", shown)) == 2
    assert re.search(r"cycle 1 failed|cycle 1/2: FAILURE", shown)


def test_of_many_leaves_at_once_the_last_hundred_are_shown_and_the_others_counted(watch):
    leaves = [ScriptCondition(f"check {i}", code="true") for i in range(1, 103)]
    lines = watch(PlainView, *leaves, terminal=False).splitlines()
    assert lines[0] == "2 earlier lines are not shown"
    assert [line.split("check ")[1] for line in lines[1:101]] == [str(i) for i in range(3, 103)]


def test_where_there_are_several_robots_a_line_names_its_robot(watch):
    class Reach(Step):
        robot_name = "left"

    one, two = ("panda",), ("left", "right")
    assert "left: go" not in watch(PlainView, Reach("go"), terminal=False, robots=one)
    assert "SUCCESS  left: go" in watch(PlainView, Reach("go"), terminal=False, robots=two)
