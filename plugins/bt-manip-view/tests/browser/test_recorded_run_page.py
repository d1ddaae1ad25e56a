"""What a person sees of a report that is opened from disk."""

import numpy as np
import pytest

from bt_manip.bt import AlwaysFailure, Fallback, Sleep
from bt_manip_recording import McapRecorder, RecordedScene, Recording
from bt_manip_view import run_page

from .conftest import POSITION, Window, wait_until

RANGE = "() => { const x = Bokeh.documents[0].roots()[{i}].x_range; return [x.start, x.end]; }"

GREEN = (64, 192, 87)
"""Colour of the bars of nodes that succeeded."""


@pytest.fixture(scope="module")
def open_report(open_window, tmp_path_factory):
    """Give a function that opens the report of a recording, keeping what happens there."""

    def open_report(recording) -> Window:
        path = tmp_path_factory.mktemp("report") / "report.html"
        path.write_text(run_page(Recording(recording)))
        window = open_window("about:blank")
        page, window.requests = window.page, []
        page.on("request", lambda request: window.requests.append(request.url))
        page.on("dialog", lambda dialog: window.log.append(dialog.message))
        page.on(
            "console",
            lambda line: window.log.append(line.text) if line.type == "error" else None,
        )
        page.goto(path.as_uri())
        wait_until(lambda: page.evaluate("() => window.Bokeh?.documents[0]?.is_idle"))
        wait_until(lambda: len(page.frames) == 2)
        window.frame = page.frames[1]
        return window

    return open_report


@pytest.fixture(scope="module")
def report(open_report, picked) -> Window:
    return open_report(picked)


def x_range(report, plot=0):
    return report.page.evaluate(RANGE.replace("{i}", str(plot)))


def test_nothing_is_requested_and_nothing_goes_wrong(report):
    report.wait_for_scene()
    assert not [url for url in report.requests if not url.startswith(("file:", "blob:", "data:"))]
    assert not report.log


def test_the_replay_shows_the_robot_at_each_time_that_is_chosen(report, picked):
    report.wait_for_scene()
    report.frame.locator("button:has(.tabler-icon-player-pause-filled)").dispatch_event("click")
    report.frame.locator(".tabler-icon-player-play-filled").wait_for()
    scene, box = RecordedScene(Recording(picked)), report.frame.locator("input").first
    for time in (1.5, 3.0, 2.0):
        box.fill(f"{time}")
        box.press("Enter")
        scene.seek(time)
        position = scene.poses()[scene.frames.index("cube/cube")][:3].tolist()
        near = pytest.approx(position, abs=0.05)  # [m] in the frame before
        wait_until(lambda near=near: report.evaluate(POSITION) == near)
    report.wait_for_scene()  # going back, the player makes it anew
    share = {}
    shown = report.scene("report")
    assert (shown.max(axis=2) > 40).mean() > 0.9  # the environment's light is there
    for node in ("/panda", "/cube"):
        share[node] = (abs(shown - report.scene_without(node)).max(axis=2) > 20).mean()
    assert 0.02 < share["/panda"] < 0.5
    assert 1e-4 < share["/cube"] < share["/panda"]  # in the gripper


def test_a_click_on_a_plot_shows_its_time_in_the_replay(report, picked):
    section = report.page.locator("section", has_text="Timeline of the tree")
    section.scroll_into_view_if_needed()
    box = section.locator("canvas").first.bounding_box()
    start, end = x_range(report)
    field = report.frame.locator("input").first
    for share in (0.7, 0.4):
        report.page.mouse.click(box["x"] + share * box["width"], box["y"] + 15)
        due = start + share * (end - start)
        wait_until(lambda due=due: abs(float(field.input_value()) - due) < 0.1 * (end - start))
        report.page.wait_for_timeout(500)  # two clicks at once are a double click


def test_plots_are_drawn_and_zoom_together(report):
    page = report.page
    assert page.evaluate("() => Bokeh.documents[0].roots().length") == 6
    section = page.locator("section", has_text="Timeline of the tree")
    section.scroll_into_view_if_needed()
    pixels = report.pixels(section)
    assert (abs(pixels - np.array(GREEN)).max(axis=2) < 8).mean() > 0.01
    whole = x_range(report)

    def point(share: float) -> tuple[float, float]:
        box = section.locator(".bk-Figure").bounding_box()
        return box["x"] + share * box["width"], box["y"] + 60

    def zoomed() -> bool:
        report.drag(point(0.3), point(0.5))  # lost if the plot is laid out anew meanwhile
        return x_range(report) != whole

    wait_until(zoomed)
    start, end = x_range(report)
    assert whole[0] < start < end < whole[1]
    assert x_range(report, plot=5) == [start, end]
    page.mouse.dblclick(*point(0.5))
    wait_until(lambda: x_range(report) == whole)


def test_hostile_names_are_only_text(open_report, make_run, tmp_path):
    name = "</script><script>alert(1)</script>$$x$$<img src='https://example.org'>"
    root = Fallback(name, AlwaysFailure(name), Sleep(name, msec=30))
    make_run(root).execute([McapRecorder(tmp_path / "run.mcap")])
    report = open_report(tmp_path / "run.mcap")
    report.wait_for_text("alert")
    section = report.page.locator("section", has_text="Timeline of the tree")
    section.locator(".bk-Figure").hover(position={"x": 100, "y": 15})
    report.page.wait_for_timeout(500)
    assert not [url for url in report.requests if not url.startswith(("file:", "blob:", "data:"))]
    assert not report.log
