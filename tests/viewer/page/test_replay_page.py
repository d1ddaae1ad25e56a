"""The page of a recording shows at each time what the page of the run had shown then."""

import json
import threading
import time

import numpy as np
import pytest
from mcap.reader import make_reader

from bt_manip.behaviours import MoveToConfiguration, RemoveObject, SpawnObject
from bt_manip.bt import AlwaysFailure, Fallback, Script, Sequence, Sleep
from bt_manip.cli.run_observers import page_panels
from bt_manip.plugins import load_plugins
from bt_manip.record import McapRecorder, Recording
from bt_manip.runner import RunObserver
from bt_manip.viewer import Page, Panel, ReplayPage

SHOWN = {
    "tree": ("nodes", "states", "failed"), "log": ("lines",), "blackboard": ("values",),
    "plot": ("samples",),
}  # fmt: skip
"""Properties of elements that are the same in a run and in its replay."""


def texts_of(page):
    """Return the contents of the elements, up to date."""
    for panel in page._panels:
        panel.draw()
    return [
        rounded([element.props[name] for name in SHOWN[element.kind]])
        for element in page.gui._elements.values()
        if element.kind in SHOWN and element.props.get("samples") != []
    ]


def rounded(value):
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(one) for one in value]
    return round(value, 5) if isinstance(value, float) else value


class States(RunObserver):
    """Keep what the page of a run shows before each tick, and its nodes of entities."""

    def __init__(self, page):
        self.page, self.seen = page, {}

    def run_started(self, run):
        self.cell = run.station.cell

    def before_tick(self):
        self.page.refresh(now=True)
        self.seen[self.cell.time] = texts_of(self.page), set(self.page._scene._shown)


@pytest.fixture(scope="module")
def panels():
    """Give the panels that do not need a run, guarded as those of the command line."""
    makers = page_panels(load_plugins(entry_points=()))
    return {name: maker for name, maker in makers.items() if not maker.needs_run}


@pytest.fixture(scope="module")
def recorded(make_run, panels, tmp_path_factory):
    """Record two cycles on a page; return the file, and what the page showed at each time."""
    path = tmp_path_factory.mktemp("replay") / "run.mcap"
    root = Sequence(
        "root",
        Script(code="speed := 0.5"),
        SpawnObject(object="{cube}"),
        MoveToConfiguration(configuration=[0.1, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]),
        Sleep("rest", msec=200),
        RemoveObject(object="{cube}"),
        Fallback("rescue", AlwaysFailure("never"), Sleep(msec=30)),
    )
    page = Page(panels, port=0, speed=None)
    try:
        states = States(page)
        make_run(root, cycles=2).execute([McapRecorder(path), page, states])
    finally:
        page.close()
    return path, states.seen


@pytest.fixture
def replay(recorded, panels):
    page = ReplayPage(Recording(recorded[0]), panels, port=0)
    yield page
    page.close()


def test_each_time_shows_what_the_run_had_shown(recorded, replay):
    _, seen = recorded
    times = list(seen)
    np.random.default_rng(0).shuffle(times)
    for moment in (*times, *sorted(times)[:5]):
        replay.seek(moment)
        texts, entities = seen[moment]
        assert texts_of(replay) == texts
        assert set(replay._scene._shown) == entities


def test_poses_are_the_recorded_ones(replay):
    scene = replay._timeline.scene
    for moment in (0.3, 0.1, 0.2):
        replay.seek(moment)
        poses = dict(zip(scene.frames, scene.poses(), strict=True))
        for name, nodes in replay._scene._frames.items():
            for body, node in nodes.items():
                found = np.concatenate([node.position, node.wxyz])
                np.testing.assert_allclose(found, poses[body], atol=2e-5, err_msg=name)


@pytest.fixture
def playing(replay):
    """Serve the page in another thread."""
    done = threading.Event()
    thread = threading.Thread(target=lambda: replay.serve(done.is_set))
    thread.start()
    yield replay
    done.set()
    thread.join(30)


def wait_until(condition):
    deadline = time.monotonic() + 30.0  # [s] of a hopeless wait, not of a passing test
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_it_plays_to_the_end_and_then_once_more(playing):
    scene, controls = playing._timeline.scene, playing.controls
    end = scene.times[-1]
    time.sleep(0.2)
    assert controls.paused and scene.time == 0.0
    for _ in range(2):
        controls._toggle(None)
        wait_until(lambda: 0.0 < scene.time < end)
        wait_until(lambda: controls.paused)
        assert scene.time == pytest.approx(end)


def test_it_makes_single_ticks(playing):
    scene, controls = playing._timeline.scene, playing.controls
    for tick in (1, 2, 3):
        controls._add_step(None)
        wait_until(lambda due=scene.times[tick]: scene.time == due)
        assert controls.paused


def test_the_time_line_chooses_the_time(playing):
    (line,) = (one for one in playing.gui._elements.values() if one.kind == "timeline")
    for wanted in (0.25, 0.1):
        data = json.dumps({"id": line.uid, "event": "seek", "value": wanted})
        assert playing.gui.receive(data)
        wait_until(lambda due=wanted: playing._timeline.scene.time == pytest.approx(due))
        wait_until(lambda due=wanted: line.time == pytest.approx(due))


def test_the_time_line_has_the_whole_recording_at_any_time(replay):
    (line,) = (one for one in replay.gui._elements.values() if one.kind == "timeline")
    before = list(line.leaves), list(line.marks)
    assert {name for _, _, name in before[0]} >= {"rest", "MoveToConfiguration", ""}
    assert [text for _, kind, text in before[1] if kind == "cycle"] == ["cycle 1", "cycle 2"]
    assert any(kind == "failure" and "never" in text for _, kind, text in before[1])
    for moment in (0.5, 0.1):
        replay.seek(moment)
        assert (line.leaves, line.marks) == before
    assert line.end == pytest.approx(replay._timeline.scene.times[-1])


def test_playing_pauses_at_a_breakpoint_but_moving_past_it_does_not(playing):
    scene, controls = playing._timeline.scene, playing.controls
    controls.breakpoints = frozenset(["rest"])
    controls.want(float(scene.times[-1]))
    wait_until(lambda: scene.time == scene.times[-1])
    controls.want(0.0)
    wait_until(lambda: scene.time == 0.0)
    controls._toggle(None)
    wait_until(lambda: "paused at rest" in controls._status.text)
    assert 0.0 < scene.time < scene.times[-1]
    controls._toggle(None)
    controls._toggle(None)
    wait_until(lambda: controls._status.text.endswith("s: paused"))


def test_panels_that_need_a_run_are_left_out(recorded):
    made = []

    class NeedsRun(Panel):
        needs_run = True

        def __init__(self, page):
            made.append(page)

    ReplayPage(Recording(recorded[0]), {"jog": NeedsRun}, port=0).close()
    assert not made


def test_the_page_says_that_a_recording_is_incomplete(recorded, panels, tmp_path):
    with recorded[0].open("rb") as file:
        chunk = make_reader(file).get_summary().chunk_indexes[-1]
    end = chunk.chunk_start_offset + chunk.chunk_length
    (tmp_path / "cut.mcap").write_bytes(recorded[0].read_bytes()[: end + 5])
    page = ReplayPage(Recording(tmp_path / "cut.mcap"), panels, port=0, start=0.1)
    try:
        assert page._timeline.scene.time == pytest.approx(0.1)
        assert "incomplete: it was cut off after" in page.controls._status.note
    finally:
        page.close()
