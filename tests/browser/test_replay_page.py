"""What a person sees and does on the page of a recording (``bt-manip replay``)."""

import re

import pytest

from bt_manip.record import RecordedScene, Recording
from tests.browser.conftest import POSITION, Window, wait_until


@pytest.fixture(scope="module")
def window(start, open_window, picked) -> Window:
    window = open_window(start("replay", picked, "--from", "0.5", "--port", "0").url)
    window.wait_for_scene()
    return window


def go_to(window: Window, time: float) -> None:
    """Choose a time on the time line."""
    box = window.page.locator("input[inputmode=decimal]").last

    def arrived() -> bool:
        box.fill(f"{time:g}")  # lost if the page is drawn anew meanwhile
        box.press("Enter")
        window.page.wait_for_timeout(500)
        return re.search(rf"\b{time:.2f} s: ", window.text()) is not None

    wait_until(arrived)


def test_it_is_paused_at_the_chosen_start(window):
    assert window.wait_for_text(r"[\d.]+ s: \w+") == "0.50 s: paused"


def test_scrubbing_shows_the_scene_and_the_tree_of_each_time(window, picked):
    scene = RecordedScene(Recording(picked))
    lines = {}
    for time in (1.5, 3.0, 1.5, 0.2):
        go_to(window, time)
        scene.seek(time)
        x, y, z = scene.poses()[scene.frames.index("cube/cube")][:3].tolist()
        wait_until(lambda at=(x, y, z): window.evaluate(POSITION) == pytest.approx(at, abs=1e-4))
        shown = window.text().count("✓")
        assert lines.setdefault(time, shown) == shown
    assert lines[0.2] < lines[1.5] < lines[3.0]
    go_to(window, 0.0)  # before the cube comes
    wait_until(lambda: window.evaluate(POSITION) == [])


def test_the_robot_is_drawn(window):
    go_to(window, 1.5)
    with_robot = window.scene("replay")
    without = window.scene_without("/panda")
    assert (abs(with_robot.astype(int) - without).max(axis=2) > 40).mean() > 0.02


def test_it_plays_to_the_end(window):
    window.press("Play")
    window.wait_for_text("s: SUCCESS")
    window.button("Play").wait_for()
    assert not window.log
