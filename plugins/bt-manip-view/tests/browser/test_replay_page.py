"""What a person sees and does on the page of a recording (``bt-manip replay``)."""

import pytest

from bt_manip_recording import RecordedScene, Recording

from .conftest import POSITION, Window, wait_until


@pytest.fixture(scope="module")
def window(start, open_window, picked) -> Window:
    window = open_window(start("replay", picked, "--from", "0.5", "--port", "0").url)
    window.wait_for_scene()
    assert window.wait_for_text(r"[\d.]+ s: \w+") == "0.50 s: paused"
    return window


def go_to(window: Window, time: float, start: float, end: float) -> None:
    """Click at a time on the time line."""
    line = window.page.get_by_role("slider", name="Timeline")
    box = line.bounding_box()
    share = (time - start) / (end - start)
    line.click(position={"x": 8 + share * (box["width"] - 16), "y": box["height"] / 2}, force=True)
    wait_until(lambda: abs(float(line.get_attribute("aria-valuenow")) - time) < 0.02)


def test_clicks_on_the_time_line_show_the_scene_and_the_tree_of_each_time(window, picked):
    scene = RecordedScene(Recording(picked))
    start, end = float(scene.times[0]), float(scene.times[-1])
    lines = {}
    for time in (1.5, 3.0, 1.5, 0.2):
        go_to(window, time, start, end)
        scene.seek(window.time())
        x, y, z = scene.poses()[scene.frames.index("cube/cube")][:3].tolist()
        wait_until(lambda at=(x, y, z): window.evaluate(POSITION) == pytest.approx(at, abs=2e-3))
        shown = window.tree().count("✓")
        assert lines.setdefault(time, shown) == shown
    assert lines[0.2] < lines[1.5] < lines[3.0]
    window.page.keyboard.press("Home")  # before the cube comes
    wait_until(lambda: window.evaluate(POSITION) == [])
    window.page.keyboard.press("PageDown")
    wait_until(lambda: window.time() == pytest.approx(start + 1.0, abs=0.02))
    assert not window.log


@pytest.mark.soak
def test_the_robot_is_drawn(window):
    with_robot = window.scene("replay")
    without = window.scene_without("/panda")
    assert (abs(with_robot.astype(int) - without).max(axis=2) > 40).mean() > 0.02
