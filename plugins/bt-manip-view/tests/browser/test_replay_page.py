"""What a person sees and does on the page of a recording (``bt-manip replay``)."""

import pytest

from bt_manip_recording import RecordedScene, Recording

from .conftest import wait_until
from .recorded_past import Past, wrong_rows


def test_clicks_and_keys_on_the_time_line_show_the_tree_of_each_time(start, picked, open_window):
    program = start("replay", picked, "--from", "0.5", "--port", "0")
    window = open_window(program.url, scene=False)
    assert window.wait_for_text(r"[\d.]+ s: \w+") == "0.50 s: paused"
    first, last = RecordedScene(Recording(picked)).times[[0, -1]]
    line, past = window.page.get_by_role("slider", name="Timeline"), Past(picked)
    box = line.bounding_box()
    for time in (1.5, 3.0, 0.2):
        x = 8 + (time - first) / (last - first) * (box["width"] - 16)
        line.click(position={"x": x, "y": box["height"] / 2}, force=True)
        wait_until(lambda due=time: abs(window.time() - due) < 0.02)
        states = past.states(past.at(window.time())[0])
        wait_until(lambda due=states: not wrong_rows(window, due))
    for key, due in (("Home", first), ("PageDown", first + 1.0)):
        window.page.keyboard.press(key)
        wait_until(lambda due=due: window.time() == pytest.approx(due, abs=0.02))
    assert program.interrupt() == 0
