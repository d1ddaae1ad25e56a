"""What a person sees and does on the page of a recording (``bt-manip replay``)."""

import threading
from collections.abc import Iterator

import pytest

from bt_manip_recording import RecordedScene, Recording
from bt_manip_view import ReplayPage

from .conftest import Window, wait_until
from .recorded_past import Past, wrong_rows


@pytest.fixture(scope="module")
def replay(parts, picked) -> Iterator[ReplayPage]:
    """Serve a recording in another thread."""
    registered = parts.of("panels")
    panels = {name: registered.get(name) for name in registered.in_order()}
    page, done = ReplayPage(Recording(picked), panels, port=0, start=0.5), threading.Event()
    thread = threading.Thread(target=lambda: page.serve(done.is_set))
    thread.start()
    yield page
    done.set()
    thread.join(30)
    page.close()


def go_to(window: Window, time: float, start: float, end: float) -> None:
    """Click at a time on the time line."""
    line = window.page.get_by_role("slider", name="Timeline")
    box = line.bounding_box()
    share = (time - start) / (end - start)
    line.click(position={"x": 8 + share * (box["width"] - 16), "y": box["height"] / 2}, force=True)
    wait_until(lambda: abs(float(line.get_attribute("aria-valuenow")) - time) < 0.02)


def test_clicks_and_keys_on_the_time_line_show_the_tree_of_each_time(replay, picked, open_window):
    window = open_window(replay.url, scene=False)
    assert window.wait_for_text(r"[\d.]+ s: \w+") == "0.50 s: paused"
    times = RecordedScene(Recording(picked)).times
    start, end = float(times[0]), float(times[-1])
    past = Past(picked)
    for time in (1.5, 3.0, 0.2):
        go_to(window, time, start, end)
        states = past.states(past.at(window.time())[0])
        wait_until(lambda due=states: not wrong_rows(window, due))
    window.page.keyboard.press("Home")
    wait_until(lambda: window.time() == pytest.approx(start, abs=0.02))
    window.page.keyboard.press("PageDown")
    wait_until(lambda: window.time() == pytest.approx(start + 1.0, abs=0.02))
    assert not window.log
