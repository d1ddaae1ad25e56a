"""Plotted quantities of a run are those of the physics and of its recording."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.behaviours import CloseGripper, MoveToConfiguration, RemoveObject, SpawnObject
from bt_manip.bt import Script, Sequence, Sleep
from bt_manip.runner import RunObserver
from bt_manip_recording import McapRecorder, Recording, Timeline
from bt_manip_view.page.quantities import LiveQuantities, RecordedQuantities

RECORDED = (
    "Tracking error", "Joint positions", "Joint velocities", "Joint torques", "Grip force",
    "Wrist force", "Wrist torque",
)  # fmt: skip


class Sampler(RunObserver):
    """Samples the quantities, and what the cell measures, after each tick."""

    kinds = ("blackboard",)

    def run_started(self, run):
        self.run = run
        self.quantities = LiveQuantities(run, lambda: run.station.cell.time)
        self.times, self.heights = [], []

    def handle(self, event):
        self.quantities.handle(event)

    def after_tick(self):
        cell, robot = self.run.station.cell, self.run.station.robot
        self.quantities.sample()
        arm = self.run.station.arm
        joints = {"panda": (robot.q[None], arm.q_ref[None])}
        self.quantities.add_joints(np.array([cell.time]), joints)
        self.times.append(cell.time)
        self.heights.append(cell.pose("cube").translation[2] if "cube" in cell.objects else np.nan)
        if len(self.times) == 20:
            cell.move("cube", spatial.pose((0.5, -0.3, 1.3)))  # from where it falls


@pytest.fixture(scope="module")
def sampled(make_run, tmp_path_factory):
    path = tmp_path_factory.mktemp("quantities") / "run.mcap"
    root = Sequence(
        "root",
        Script(code="count := 2"),
        SpawnObject(object="{cube}"),
        CloseGripper(),
        MoveToConfiguration(configuration=[0.1, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]),
        Script(code="count := 5; name := 'x'"),
        RemoveObject(object="{cube}"),
        Sleep(msec=30),
    )
    sampler = Sampler()
    make_run(root).execute([McapRecorder(path), sampler])
    recording = Recording(path)
    return sampler, RecordedQuantities(recording, Timeline(recording))


@pytest.mark.parametrize("name", RECORDED)
def test_a_quantity_of_a_run_is_the_recorded_one(sampled, name):
    live, recorded = sampled[0].quantities.table(name), sampled[1].table(name)
    assert (live.unit, live.labels) == (recorded.unit, recorded.labels)
    assert len(live.rows) == len(sampled[0].times)
    at = np.abs(recorded.rows[:, 0, None] - live.rows[:, 0]).min(axis=1) < 1e-6
    same = recorded.rows[at]
    assert len(same) > 0.2 * len(live.rows)  # those that are left of the control steps
    index = np.searchsorted(live.rows[:, 0], same[:, 0] - 1e-6)
    np.testing.assert_allclose(live.rows[index], same, rtol=1e-5, atol=1e-5)


def test_heights_are_those_of_the_cell(sampled):
    sampler, recorded = sampled
    live = sampler.quantities.table("Height of objects")
    assert live.labels == ("cube",) and live.unit == "m"
    heights = np.array(sampler.heights)
    np.testing.assert_allclose(live.rows[:, 1], heights[~np.isnan(heights)], atol=3e-3)  # a step
    assert np.ptp(live.rows[:, 1]) > 0.2
    again = recorded.table("Height of objects")
    assert again.labels == live.labels and again.unit == live.unit
    present = again.rows[~np.isnan(again.rows[:, 1])]
    np.testing.assert_allclose(present, live.rows, atol=1e-5)


def test_numbers_of_the_blackboard_are_plotted_and_texts_are_not(sampled):
    live, recorded = sampled[0].quantities, sampled[1]
    for quantities in (live, recorded):
        assert "Blackboard count" in quantities.names()
        assert "Blackboard name" not in quantities.names()
        values = quantities.table("Blackboard count").rows[:, 1]
        assert values[0] == 2.0 and values[-1] == 5.0 and set(values) == {2.0, 5.0}


def test_a_topic_without_messages_has_no_rows(make_run, tmp_path, monkeypatch):
    make_run(Sleep(msec=20)).execute([McapRecorder(tmp_path / "run.mcap")])
    recording = Recording(tmp_path / "run.mcap")
    quantities = RecordedQuantities(recording, Timeline(recording))
    monkeypatch.setattr(recording, "messages", lambda *topics: iter(()))
    for name in ("Grip force", "Wrist force", "Joint torques"):
        assert len(quantities.table(name).rows) == 0


def test_plots_are_chosen_from_the_list_and_removed(make_run, page, connect):
    make_run(Sleep("rest", msec=50)).execute([page])
    client = connect("page").see()
    assert client.find("plot")["label"] == "Tracking error"
    offered = client.find("dropdown", "Quantity")["options"]
    assert "Tracking error" not in offered and "Joint torques" in offered
    client.set("dropdown", "Quantity", "Joint torques")
    page.refresh(now=True)
    torques = client.see().find("plot", "Joint torques")
    assert torques["unit"] == "N m" and len(torques["names"]) == 7
    expected = pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05, 0.06])
    assert [row[0] for row in torques["samples"]] == expected
    client.send(client.uid("plot", "Tracking error"), "remove")
    page.refresh(now=True)
    assert client.see().find("plot")["label"] == "Joint torques"
    assert "Tracking error" in client.find("dropdown", "Quantity")["options"]


def test_a_line_that_comes_later_is_added_to_the_plot(make_run, page, connect):
    class Adder(RunObserver):
        def run_started(self, run):
            self.station, self.count = run.station, 0

        def after_tick(self):
            self.count += 1
            if self.count in (2, 5):
                place = spatial.pose((0.5, 0.1 * self.count, 1.1))
                self.station.cell.add(self.station.models.create("cube"), place)
            page.refresh(now=True)

    client = connect("page").see()
    run = make_run(Sleep("rest", msec=80))
    run.execute([page, Adder()])
    client.set("dropdown", "Quantity", "Height of objects")
    page.refresh(now=True)
    plot = client.see().find("plot", "Height of objects")
    assert len(plot["names"]) == 2
    assert [None in row for row in plot["samples"]] == [True] * 3 + [False] * 4
