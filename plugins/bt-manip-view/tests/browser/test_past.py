"""Any past time of a run on its page: live, paused and ended, opened from the start and late."""

import json
from contextlib import closing

import pytest

from bt_manip.bt import AlwaysFailure, AlwaysSuccess, Sequence
from bt_manip_recording import Recording, Timeline
from bt_manip_view import Page

from ..conftest import PATIENCE, Program
from .conftest import Window, wait_until
from .recorded_past import Past, back_to_now, check_moments

MOMENTS = 0.1, 0.4, 0.7, 0.95
"""Shares of the shown range at which the past is compared."""

RECORD = "run.mcap"


def line_of(window: Window):
    return window.page.get_by_role("slider", name="Timeline")


def range_of(window: Window) -> tuple[float, float]:
    start, end = line_of(window).get_attribute("data-range").split()
    return float(start), float(end)


@pytest.fixture(scope="module")
def program(start) -> Program:
    arguments = ("--cycles", "0", "--seed", "3", "--view", "--record", RECORD)
    arguments += ("--view-breakpoints", "SpawnObject", "--real-time", "5")
    return start("run", "pick_place", *arguments)


@pytest.fixture(scope="module")
def path(program):
    return program.errors.with_name(RECORD)


@pytest.fixture(scope="module")
def early(program, open_window) -> Window:
    """Open the page at the start; when the scene is there, the run goes on."""
    window = open_window(program.url, light=False)
    window.wait_for_scene()
    window.wait_for_text("s: paused at SpawnObject")
    window.set_breakpoint("SpawnObject")
    window.press("Continue")
    wait_until(lambda: window.time() > 5.0)
    window.choose("Speed", "1")
    return window


def test_any_past_time_of_a_run_that_goes_on_is_that_of_its_recording(early, path):
    check_moments(early, path, share_of=MOMENTS[1::2])
    moment = float(line_of(early).get_attribute("data-shown"))
    wait_until(lambda: early.time() > moment + 0.3)  # while the run goes on
    assert float(line_of(early).get_attribute("data-shown")) == moment
    back_to_now(early)
    early.wait_for_tree(r"▶ (Hover|Reach|Lift|Drop) ")  # it follows again


def test_a_page_that_is_opened_late_has_the_past_of_a_paused_run_and_what_its_address_says(
    early, path, program, open_window
):
    early.press("Pause")
    early.wait_for_text("s: paused")
    window, line = early, line_of(early)
    window.press("Whole run")
    wait_until(lambda: range_of(window)[0] == 0.0)
    whole, box = range_of(window), line.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + 30
    window.page.mouse.move(*middle)
    window.page.mouse.wheel(0, -500)
    wait_until(lambda: range_of(window)[1] - range_of(window)[0] < 0.5 * whole[1])
    window.press("Whole run")
    window.page.keyboard.down("Shift")
    window.drag((box["x"] + 0.25 * box["width"], middle[1]), middle)
    window.page.keyboard.up("Shift")
    expected = pytest.approx((0.25 * whole[1], 0.5 * whole[1]), rel=0.05)
    wait_until(lambda: range_of(window) == expected)
    line.click(position={"x": box["width"] / 2, "y": 30}, force=True)
    window.button("Back to now").wait_for()
    clicked = line.get_attribute("data-shown")
    window.page.evaluate("page.seek(page.shown() - 2e-4)")  # just before a state: the earlier one
    wait_until(lambda: line.get_attribute("data-shown") != clicked)
    assert "at=" in window.page.url
    address, shown = window.page.url, line.get_attribute("data-shown")
    back_to_now(window)
    late = open_window(address, scene=False)
    wait_until(lambda: line_of(late).get_attribute("data-shown") == shown)
    assert range_of(late) == pytest.approx(range_of(window), abs=2e-3)
    late.press("Whole run")
    check_moments(late, path, share_of=MOMENTS[:1], scene=False)
    shown = line_of(late).get_attribute("data-shown")
    wait_until(lambda: line_of(early).get_attribute("data-shown") == shown)  # all show the same
    back_to_now(late)
    late.page.context.close()
    window.press("Whole run")


def test_the_run_that_has_ended_is_the_past_of_its_recording_however_late_its_page_is_opened(
    early, path, program
):
    back_to_now(early)
    early.press("Stop")
    program.wait_for("stays up")
    early.wait_for_text("Run starts it again")  # the result comes to the front
    check_moments(early, path, share_of=MOMENTS[:1])
    early.page.reload()
    early.wait_for_scene()
    check_moments(early, path, share_of=MOMENTS[2:3])
    back_to_now(early)
    line = line_of(early)
    now = float(line.get_attribute("aria-valuenow"))
    line.focus()
    early.page.keyboard.press("ArrowLeft")
    wait_until(
        lambda: float(line.get_attribute("aria-valuenow")) == pytest.approx(now - 0.1, abs=0.02)
    )
    early.page.keyboard.press("End")
    wait_until(lambda: float(line.get_attribute("aria-valuenow")) == pytest.approx(now, abs=0.02))


def test_recording_and_report_of_the_run_on_the_page_can_be_saved(early, path, program, tmp_path):
    with early.page.expect_download(timeout=1e3 * PATIENCE) as saved:
        early.page.get_by_text("Save recording", exact=True).dispatch_event("click")
    assert saved.value.suggested_filename == "pick_place-3.mcap"
    saved.value.save_as(tmp_path / RECORD)
    mine, full = Past(tmp_path / RECORD), Past(path)
    assert len(mine.times) == pytest.approx(len(full.times), abs=50)  # while the arm stops
    for moment in (1.0, 4.0):
        assert mine.states(mine.at(moment)[0]) == full.states(full.at(moment)[0])
    assert len(Timeline(Recording(tmp_path / RECORD)).times) == len(mine.times)
    early.page.get_by_text("Report", exact=True).and_(early.page.locator("[href]")).wait_for()
    with early.page.expect_download(timeout=1e3 * PATIENCE) as saved:
        early.page.get_by_text("Report", exact=True).dispatch_event("click")
    assert json.loads(saved.value.path().read_text())["status"] == "INTERRUPTED"
    assert program.interrupt() == 130


@pytest.mark.soak
def test_a_run_of_two_robots_that_has_ended_is_shown_as_a_whole(start, open_window):
    program = start("run", "two_arms", "--view", "--record", RECORD, "--real-time", "0")
    first = open_window(program.url)  # the run begins
    program.wait_for("stays up")
    first.page.context.close()
    window = open_window(program.url)
    window.wait_for_scene()
    check_moments(window, program.errors.with_name(RECORD), share_of=MOMENTS[1::2])
    back_to_now(window)
    window.wait_for_text("left and right in two_arms, seed 0")
    assert line_of(window).get_attribute("data-lanes") == "left right"
    pixels = window.pixels(line_of(window))
    for y in (0.4, 0.65):  # the lanes
        row = pixels[int(y * len(pixels))]
        assert len({tuple(one) for one in row.tolist()}) > 4  # leaves in each of them


@pytest.mark.parametrize("failing", [pytest.param(None, marks=pytest.mark.soak), 14])
def test_a_large_tree_that_has_ended_opens_where_it_failed_or_two_levels(
    make_run, parts, open_window, failing
):
    leaves = (AlwaysFailure if i == failing else AlwaysSuccess for i in range(16))
    nodes = [
        Sequence(f"part {i}", AlwaysSuccess(f"first of {i}"), leaf(f"second of {i}"))
        for i, leaf in enumerate(leaves)
    ]
    panels = {"tree": parts.of("panels").get("tree")}
    with closing(Page(panels, port=0, speed=None)) as page:
        make_run(Sequence("all", nodes)).execute([page])
        window = open_window(page.url, scene=False)
        window.wait_for_tree("part 13")
        shown = window.tree()
        assert "first of 2" not in shown
        assert ("second of 14" in shown) == (failing is not None)
        window.page.context.close()
