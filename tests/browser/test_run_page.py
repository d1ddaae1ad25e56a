"""What a person sees and does on the page of a run (``--view``)."""

import time

import pytest

from bt_manip import build_station
from bt_manip.viewer import render
from tests.browser.conftest import Program, Window, wait_until


@pytest.fixture(scope="module")
def program(start) -> Program:
    return start("run", "pick_place", "--cycles", "0", "--seed", "3", "--view", "--real-time", "1")


@pytest.fixture
def paused(window) -> Window:
    window.press("Pause")
    window.wait_for_text("s: paused")
    return window


def test_the_robot_is_drawn_as_the_overview_camera_sees_it(opengl, paused):
    shown = paused.scene("picking")
    share = (abs(shown - paused.scene_without("/panda")).max(axis=2) > 20).mean()
    cell = build_station().cell
    height, width = shown.shape[:2]
    expected = render(cell, width=width, height=height).astype(int)
    cell.model.geom_rgba[_robot(cell.model)] = 0.0
    cell.model.geom_matid[_robot(cell.model)] = -1
    without = render(cell, width=width, height=height).astype(int)
    assert share == pytest.approx((abs(expected - without).max(axis=2) > 20).mean(), rel=0.3)


def _robot(model):
    names = [model.body(body).name for body in model.geom_bodyid]
    return [geom for geom, name in enumerate(names) if name.startswith("panda/")]


def test_the_tree_follows_the_run_with_statuses_and_reasons(window):
    window.wait_for_text("▶ Hover|▶ Reach|▶ Lift|▶ Drop")
    window.wait_for_text("✓ SpawnObject")
    window.wait_for_text("✗ IsHolding the gripper holds nothing, not 'cube'")


def test_a_paused_run_stands_still_and_makes_single_ticks(paused):
    before = paused.time()
    time.sleep(0.5)
    assert paused.time() == before
    for tick in (1, 2):
        paused.press("Step one tick")
        wait_until(lambda due=before + 0.01 * tick: abs(paused.time() - due) < 1e-6)
    paused.press("Continue")
    wait_until(lambda: paused.time() > before + 0.5)


def test_the_speed_can_be_changed(window):
    window.choose("Speed", "1/10")
    time.sleep(0.5)  # until the run has it
    start, before = time.monotonic(), window.time()
    time.sleep(2.0)
    after, elapsed = window.time(), time.monotonic() - start
    assert 0.0 < after - before < 0.1 * elapsed + 0.1
    window.choose("Speed", "1")
    wait_until(lambda: window.time() > after + 1.0)


def test_a_breakpoint_pauses_where_its_node_starts(window):
    window.choose("Node", "attempt/pick/Lift::20")
    window.wait_for_text("Action Lift, ")
    window.press("Breakpoint")
    try:
        window.wait_for_text("s: paused at attempt/pick/Lift::20")
        assert "▶ Lift" in window.text()
    finally:
        window.press("✕ attempt/pick/Lift::20")


def test_log_blackboard_and_plot_are_in_tabs(window):
    window.wait_for_text("s cube added")
    window.wait_for_text("s cycle 1 started")
    window.open_tab("Blackboard")
    window.wait_for_text("cube\\s+auto")
    window.open_tab("Tracking error")
    plot = window.page.locator(".uplot canvas")
    plot.wait_for()
    drawn = plot.evaluate(
        "canvas => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data"
        ".filter((value, index) => index % 4 == 3 && value > 0).length"
    )
    assert drawn > 100
    window.keep("plot")
    window.open_tab("Log")


def test_stop_ends_the_run_with_the_exit_code_of_an_interrupted_one(program, window):
    window.press("Stop")
    window.wait_for_text("s: stopped")
    program.wait_for("stays up")
    assert program.interrupt() == 130
    assert not program.errors.read_text()
