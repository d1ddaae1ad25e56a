"""What a person sees of a report that is opened from disk."""

from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import pytest

from bt_manip.runner import RunRequest, TreeSource, prepare
from bt_manip_recording import McapRecorder, RecordedScene, Recording
from bt_manip_view import run_page

from .conftest import Window, wait_until

RANGE = "() => { const x = Bokeh.documents[0].roots()[{i}].x_range; return [x.start, x.end]; }"

GREEN = (64, 192, 87)
"""Colour of the bars of nodes that succeeded."""


NAME = "</script><script>alert(1)</script>$$x$$<img src='https://example.org'>"

TREE = f"""<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence name={quoteattr(NAME)}>
  <SpawnObject region="0.3;0.3;-0.2;-0.2" object="{{cube}}"/>
  <Fallback>
    <IsHolding name={quoteattr(NAME)} object="{{cube}}"/>
    <MoveToConfiguration configuration="1.2;0.3;0;-1.8;0;2.1;0.8" speed="0.7"/>
  </Fallback>
</Sequence></BehaviorTree></root>"""

HAND = "panda/hand"


@pytest.fixture(scope="module")
def recorded(parts, tmp_path_factory) -> Path:
    """Record a motion with hostile names of nodes."""
    folder = tmp_path_factory.mktemp("report")
    (folder / "tree.xml").write_text(TREE)
    run = prepare(RunRequest(TreeSource("pick", "xml", path=folder / "tree.xml")), parts)
    run.execute([McapRecorder(folder / "run.mcap")])
    return folder / "run.mcap"


@pytest.fixture(scope="module")
def report(open_window, recorded) -> Window:
    """Open the report of the recording, keeping what happens there."""
    path = recorded.with_suffix(".html")
    path.write_text(run_page(Recording(recorded)))
    window = open_window("about:blank")
    page, window.requests = window.page, []
    page.set_viewport_size({"width": 900, "height": 720})
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


def x_range(report, plot=0):
    return report.page.evaluate(RANGE.replace("{i}", str(plot)))


def test_the_replay_shows_the_robot_at_each_time_that_is_chosen(opengl, report, recorded):
    report.frame.locator("button:has(.tabler-icon-player-pause-filled)").dispatch_event("click")
    report.frame.locator(".tabler-icon-player-play-filled").wait_for()
    scene, box = RecordedScene(Recording(recorded)), report.frame.locator("input").first
    end, positions = float(scene.times[-1]), []
    for share in (0.9, 0.4):
        box.fill(f"{share * end}")
        box.press("Enter")
        scene.seek(share * end)
        positions.append(scene.poses()[scene.frames.index(HAND)][:3])
        wait_until(  # [m] in the frame before
            lambda: np.allclose(report.position("/panda/panda:hand"), positions[-1], atol=0.06)
        )
    assert np.linalg.norm(positions[0] - positions[1]) > 0.2
    report.wait_for_scene()
    shown = report.scene("report")
    assert (shown.max(axis=2) > 40).mean() > 0.9  # the environment's light is there
    changed = abs(shown - report.scene_without("/panda")).max(axis=2) > 20
    assert 0.02 < changed.mean() < 0.5


def test_a_click_on_a_plot_shows_its_time_in_the_replay(report):
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


def test_hostile_names_are_only_text_and_nothing_is_requested(report):
    report.wait_for_text("alert")
    section = report.page.locator("section", has_text="Timeline of the tree")
    section.scroll_into_view_if_needed()
    section.locator(".bk-Figure").hover(position={"x": 100, "y": 15})
    report.page.wait_for_timeout(500)
    assert not [url for url in report.requests if not url.startswith(("file:", "blob:", "data:"))]
    assert not report.log
