"""An object is pulled by its handle, and let go with it."""

import time

import numpy as np
import pytest

from bt_manip.behaviours import RemoveObject, SpawnObject
from bt_manip.bt import Sequence, Sleep
from bt_manip.runner import RunObserver

from .conftest import wait_until

HANDLE = "/handle"


class Hand(RunObserver):
    """Acts on the page at ticks; keeps the height of the cube."""

    def __init__(self, page, client, scene):
        self.page, self.client, self.scene = page, client, scene
        self.tick, self.actions, self.events, self.heights = 0, {}, [], []

    def run_started(self, run):
        self.cell = run.station.cell
        run.interventions.observers.append(lambda data: self.events.append(dict(data)))

    def before_tick(self):
        self.tick += 1
        if action := self.actions.get(self.tick):
            self.page.refresh(now=True)
            self.scene.see()
            action()
        if "cube" in self.cell.entities:
            self.heights.append(self.cell.data.xpos[self.cell.body_id("cube")][2])

    def click_cube(self):
        """Click the cube in the scene."""
        self.scene.act({
            "type": "SceneNodeClickMessage", "owner": "", "modifier": None, "instance_index": None,
            "name": next(name for name in self.scene.nodes if name.startswith("/cube/cube:cube/")),
            "ray_origin": (0.0,) * 3, "ray_direction": (0.0, 0.0, 1.0), "screen_pos": (0.5, 0.5),
        })  # fmt: skip
        wait_until(lambda: self.chosen["value"] == "cube")

    @property
    def chosen(self):
        """Properties of the choice of the object."""
        return self.client.see().find("dropdown", "Object")

    @property
    def handle(self):
        """Properties of the handle, if it is shown."""
        return self.scene.see().nodes.get(HANDLE)

    def drag(self, *position):
        self.scene.drag(HANDLE, position, start=True)


@pytest.fixture
def hand(page, client, scene):
    return Hand(page, client, scene)


def tree(*more):
    return Sequence("root", SpawnObject(object="{cube}"), Sleep(msec=1500), *more)


def test_a_dragged_object_follows_and_falls_when_it_is_let_go(make_run, page, hand):
    lines = []
    hand.actions |= dict.fromkeys(
        (9, 12, 50, 95, 105, 140), lambda: lines.append("/pull" in hand.scene.nodes)
    )
    hand.actions |= {
        5: hand.click_cube,
        10: lambda: hand.drag(0.3, 0.0, 1.2),
        20: lambda: hand.scene.drag(HANDLE, (0.3, 0.0, 1.4)),
        30: lambda: hand.client.set("slider", "Maximum force [N]", 80.0),
        100: lambda: hand.scene.drag(HANDLE),
    }
    run = make_run(tree())
    run.execute([page, hand])
    targets = [0.3, 0.0, 1.2], [0.3, 0.0, 1.4], [0.3, 0.0, 1.4], None
    assert [(event["target"], event.get("max_force")) for event in hand.events] == list(
        zip(targets, (50.0, 50.0, 80.0, None), strict=True)
    )
    assert max(hand.heights) > hand.heights[9] + 0.1
    assert hand.heights[-1] == pytest.approx(hand.heights[9], abs=0.01)
    assert lines == [False, True, True, True, False, False]
    assert np.abs(hand.handle["position"][2] - hand.heights[-1]) < 0.01
    page.begin_idle(run.station)
    assert hand.handle is None  # only a run can be perturbed


def test_a_page_that_is_closed_lets_go(make_run, page, hand, connect):
    other = connect()
    other.act()

    def leave():
        other.close()
        time.sleep(0.2)
        page.refresh(now=True)
        assert "/pull" in hand.scene.see().nodes
        hand.scene.close()
        hand.scene = connect()
        wait_until(lambda: (page.refresh(now=True), "/pull" not in hand.scene.see().nodes)[1])

    hand.actions |= {5: hand.click_cube, 10: lambda: hand.drag(0.3, 0.0, 1.2), 20: leave}
    make_run(tree()).execute([page, hand])
    assert [event["target"] for event in hand.events] == [[0.3, 0.0, 1.2], None]


def test_objects_that_can_move_are_offered_and_one_that_vanishes_ends_its_pull(
    make_run, page, hand
):
    options = []
    hand.actions |= {
        5: hand.click_cube,
        10: lambda: options.extend(hand.chosen["options"]),
        140: lambda: hand.drag(0.3, 0.0, 1.2),
    }
    make_run(tree(RemoveObject(object="{cube}"), Sleep(msec=50))).execute([page, hand])
    assert "cube" in options and "panda" not in options and "table" not in options
    assert "cube" not in hand.chosen["options"]
    assert hand.events[-1]["target"] is None
    assert hand.handle is None and "/pull" not in hand.scene.nodes
