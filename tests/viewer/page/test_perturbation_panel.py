"""An object is pulled by its handle, and let go with it."""

import asyncio
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from bt_manip.behaviours import RemoveObject, SpawnObject
from bt_manip.bt import Sequence, Sleep
from bt_manip.record import Recorder
from bt_manip.runner import RunObserver


@pytest.fixture
def panel(page):
    (panel,) = [panel for panel in page._panels if type(panel).__name__ == "PerturbationPanel"]
    return panel


def drag(panel, phase, position=(0.0, 0.0, 0.0)):
    target = SimpleNamespace(position=np.array(position, dtype=float))
    event = SimpleNamespace(phase=phase, client_id=1, target=target)
    # As viser does, in another thread; this one may have the loop of a browser.
    with ThreadPoolExecutor(1) as thread:
        thread.submit(asyncio.run, panel._dragged(event)).result()


class Hand(RunObserver):
    """Calls functions at ticks; keeps the height of the cube."""

    def __init__(self, panel, actions):
        self.panel, self.actions, self.heights, self.lines = panel, actions, [], []

    def run_started(self, run):
        self.run = run
        self.events = []
        run.interventions.observers.append(lambda data: self.events.append(dict(data)))

    def before_tick(self):
        self.panel.draw()
        self.lines.append(self.panel._line.handle is not None)
        if action := self.actions.get(len(self.lines)):
            action()
        if "cube" in self.run.station.cell.entities:
            cell = self.run.station.cell
            self.heights.append(cell.data.xpos[cell.body_id("cube")][2])


def tree(*more):
    return Sequence("root", SpawnObject(object="{cube}"), Sleep(msec=1500), *more)


def choose(panel):
    panel._choice.value = "cube"


def test_a_dragged_object_follows_and_falls_when_it_is_let_go(make_run, page, panel):
    hand = Hand(panel, {
        5: lambda: choose(panel),
        10: lambda: drag(panel, "start", (0.3, 0.0, 1.2)),
        20: lambda: drag(panel, "update", (0.3, 0.0, 1.4)),
        100: lambda: drag(panel, "end"),
    })  # fmt: skip
    make_run(tree()).execute([page, hand])
    assert [event["target"] for event in hand.events] == [[0.3, 0.0, 1.2], [0.3, 0.0, 1.4], None]
    assert hand.events[0]["max_force"] == 50.0
    assert max(hand.heights) > hand.heights[9] + 0.1
    assert hand.heights[-1] == pytest.approx(hand.heights[9], abs=0.01)
    assert not any(hand.lines[:10]) and all(hand.lines[12:95]) and not any(hand.lines[105:])
    assert np.abs(panel._handle.position[2] - hand.heights[-1]) < 0.01


def test_the_maximum_force_can_be_changed_during_a_pull(make_run, page, panel):
    hand = Hand(panel, {
        5: lambda: choose(panel),
        10: lambda: drag(panel, "update", (0.3, 0.0, 1.2)),
        20: lambda: setattr(panel._force, "value", 80.0),
    })  # fmt: skip
    make_run(tree()).execute([page, hand])
    assert [event.get("max_force") for event in hand.events[:2]] == [50.0, 80.0]
    assert hand.events[1]["target"] == [0.3, 0.0, 1.2]


def test_only_objects_that_can_move_are_offered(make_run, page, panel):
    hand = Hand(panel, {})
    options = []
    hand.actions[10] = lambda: options.extend(panel._choice.options)
    make_run(tree(RemoveObject(object="{cube}"), Sleep(msec=20))).execute([page, hand])
    assert "cube" in options and "panda" not in options and "table" not in options
    assert "cube" not in panel._choice.options


def test_a_page_that_is_closed_lets_go(make_run, page, panel, connect):
    browser, other = connect(), connect()

    def begin():
        pose = {"wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.3, 0.0, 1.2)}
        camera = pose | {
            "fov": 1.0, "near": 0.1, "far": 9.0, "image_height": 9, "image_width": 9,
            "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0),
        }  # fmt: skip
        handle = {"name": "/handle", "owner": ""}
        for kind, fields in (
            ("ViewerCamera", camera),
            ("TransformControlsDragStart", handle),
            ("TransformControlsUpdate", handle | pose),
        ):
            message = {"type": f"{kind}Message", **fields}
            browser.connection.send(msgspec.msgpack.encode(message))
        wait_until(lambda: panel._target == [0.3, 0.0, 1.2])

    def leave():
        other.close()
        time.sleep(0.2)
        assert panel._target is not None
        browser.close()
        wait_until(lambda: panel._target is None)

    hand = Hand(panel, {5: lambda: choose(panel), 10: begin, 20: leave})
    make_run(tree()).execute([page, hand])
    assert [event["target"] for event in hand.events] == [[0.3, 0.0, 1.2], None]


def wait_until(condition):
    deadline = time.monotonic() + 30.0  # [s] of a hopeless wait, not of a passing test
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_an_object_that_vanishes_while_it_is_pulled_ends_the_pull(make_run, page, panel):
    hand = Hand(panel, {
        5: lambda: choose(panel),
        140: lambda: drag(panel, "update", (0.3, 0.0, 1.2)),
    })  # fmt: skip
    run = make_run(tree(RemoveObject(object="{cube}"), Sleep(msec=50)))
    run.execute([page, hand])
    assert hand.events[-1]["target"] is None
    assert panel._handle is None and panel._line.handle is None


@pytest.mark.parametrize("position", [(np.nan, 0, 0), (0, 0), (np.inf, 0, 0)], ids=str)
def test_a_malformed_position_is_ignored(make_run, page, panel, position):
    def digest(*observers):
        recorder = Recorder("test", 0)
        make_run(tree()).execute([recorder, *observers])
        return recorder.report().state_digest

    hand = Hand(panel, {
        5: lambda: choose(panel), 10: lambda: drag(panel, "update", position)
    })  # fmt: skip
    assert digest(page, hand) == digest()
    assert not hand.events


def test_there_is_no_handle_without_a_run(make_run, page, panel):
    hand = Hand(panel, {5: lambda: choose(panel)})
    run = make_run(tree())
    run.execute([page, hand])
    assert panel._handle is not None
    page.begin_idle(run.station)
    assert panel._handle is None
