"""The page of a recording shows at each time what the page of the run had shown then."""

import threading
import time
from contextlib import closing
from importlib.metadata import EntryPoint

import numpy as np
import pytest

from bt_manip.behaviours import MoveToConfiguration, RemoveObject, SpawnObject
from bt_manip.bt import AlwaysFailure, Fallback, Script, Sequence, Sleep
from bt_manip.exceptions import BtManipError
from bt_manip.plugins import load_plugins
from bt_manip.runner import RunObserver
from bt_manip_recording import McapRecorder, RecordedScene, Recording
from bt_manip_view import Page, ReplayPage
from bt_manip_view.page.plugin_panels import page_panels

from .conftest import Client, SceneClient, wait_until

SHOWN = {
    "tree": ("nodes", "states", "failed"), "log": ("lines",), "blackboard": ("values",),
}  # fmt: skip
"""Properties of elements that are the same in a run and in its replay."""

VIEW = [EntryPoint("view", "bt_manip_view.plugin", "bt_manip")]
"""The entry point of this package."""


def shown_on(client):
    """Return the properties of the elements, as browsers have them."""
    return [
        rounded([element[name] for name in SHOWN[element["kind"]]])
        for element in client.see().elements.values()
        if element["kind"] in SHOWN
    ]


def entities_in(scene):
    """Return the names of the shown entities, of which one that has come again has a number."""
    nodes = [name for name in scene.see().nodes if name.count("/") == 1 and name != "/WorldAxes"]
    return {name[1:].partition(" (")[0] for name in nodes}


def rounded(value):
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(one) for one in value]
    return round(value, 5) if isinstance(value, float) else value


class States(RunObserver):
    """Keep what the page of a run shows before each tick, and the entities of its scene."""

    def __init__(self, page):
        self.page, self.seen = page, {}
        self.client, self.scene = Client(page), SceneClient(page)

    def close(self):
        self.client.close()
        self.scene.close()

    def run_started(self, run):
        self.cell = run.station.cell

    def before_tick(self):
        self.page.refresh(now=True)
        self.seen[self.cell.time] = shown_on(self.client), entities_in(self.scene)

    def look_back(self, times):
        """Return what the page shows then at some times, now."""
        seen = {}
        for moment in times:
            self.page.show_time(moment)
            self.page.refresh(now=True)
            seen[moment] = shown_on(self.client), entities_in(self.scene)
        self.page.show_time(None)
        self.page.refresh(now=True)
        return seen


@pytest.fixture(scope="module")
def panels():
    """Give the panels that do not need a run, guarded as those of the command line."""
    makers = page_panels(load_plugins(entry_points=VIEW))
    return {name: maker for name, maker in makers.items() if not maker.needs_run}


@pytest.fixture(scope="module")
def recorded(make_run, panels, tmp_path_factory):
    """Record two cycles on a page; return the file, what the page showed at each time, and later.

    The page is looked back on when the run has ended, and when its cell has rested for ten minutes.
    """
    path = tmp_path_factory.mktemp("replay") / "run.mcap"
    root = Sequence(
        "root",
        Script(code="speed := 0.5"),
        SpawnObject(object="{cube}"),
        MoveToConfiguration(configuration=[0.1, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]),
        Sleep("rest", msec=100),
        RemoveObject(object="{cube}"),
        Fallback("rescue", AlwaysFailure("never"), Sleep(msec=30)),
    )
    with closing(Page(panels, port=0, speed=None)) as page, closing(States(page)) as states:
        run = make_run(root, cycles=2)
        run.execute([McapRecorder(path), page, states])
        times = np.random.default_rng(1).permutation(list(states.seen)).tolist()[:40]
        end = shown_on(states.client)
        later = [states.look_back(times)]
        page.begin_idle(run.station)
        run.station.cell.data.time += 600.0
        later += [states.look_back(times[:20])]
        assert shown_on(states.client) == end  # the present again
    return path, states.seen, later


@pytest.fixture
def page(recorded, panels):
    page = ReplayPage(Recording(recorded[0]), panels, port=0)
    yield page
    page.close()


def test_each_time_shows_what_the_run_had_shown(recorded, page, client, scene):
    _, seen, _ = recorded
    times = np.random.default_rng(0).permutation(list(seen)).tolist()[:40]
    for moment in (*times, *list(seen)[:5], list(seen)[-1]):
        page.seek(moment)
        texts, entities = seen[moment]
        assert shown_on(client) == texts
        assert entities_in(scene) == entities


def test_a_run_that_has_ended_shows_at_each_time_what_it_had_shown_then(recorded):
    _, seen, later = recorded
    for shown_later in later:
        assert len(shown_later) >= 20
        for moment, shown in shown_later.items():
            assert shown == seen[moment]


@pytest.fixture
def times(recorded):
    return RecordedScene(Recording(recorded[0])).times


@pytest.fixture
def shown_time(client):
    """Give a function that returns the shown time [s]."""
    return lambda: client.see().find("timeline")["time"]


@pytest.fixture
def playing(page):
    """Serve the page in another thread."""
    done = threading.Event()
    thread = threading.Thread(target=lambda: page.serve(done.is_set))
    thread.start()
    yield page
    done.set()
    thread.join(30)


def test_it_plays_to_the_end_and_then_once_more(playing, client, times, shown_time):
    time.sleep(0.2)
    assert playing.controls.paused and shown_time() == 0.0
    for _ in range(2):
        client.toggle()
        wait_until(lambda: 0.0 < shown_time() < times[-1])
        wait_until(lambda: playing.controls.paused)
        wait_until(lambda: shown_time() == pytest.approx(times[-1]))


def test_it_makes_single_ticks_and_the_time_line_chooses_the_time(
    playing, client, times, shown_time
):
    for tick in (1, 2):
        client.press("Step")
        wait_until(lambda due=times[tick]: shown_time() == pytest.approx(due))
        assert playing.controls.paused
    for wanted in (0.25, 0.1):
        client.send(client.see().uid("timeline"), "seek", wanted)
        wait_until(lambda due=wanted: shown_time() == pytest.approx(due))


def test_the_time_line_has_the_whole_recording_at_any_time(page, client, times):
    line = client.see().find("timeline")
    before = line["leaves"], line["marks"]
    assert {name for _, _, name, _ in before[0]} >= {"rest", "MoveToConfiguration", ""}
    assert [text for _, kind, text in before[1] if kind == "cycle"] == ["cycle 1", "cycle 2"]
    assert any(kind == "failure" and "never" in text for _, kind, text in before[1])
    for moment in (0.5, 0.1):
        page.seek(moment)
        line = client.see().find("timeline")
        assert (line["leaves"], line["marks"]) == before
    assert line["end"] == pytest.approx(times[-1])


def test_playing_pauses_at_a_breakpoint_but_moving_past_it_does_not(
    playing, client, times, shown_time
):
    def status():
        return client.see().find("status")["text"]

    playing.controls.breakpoints = frozenset(["rest"])
    for wanted in (times[-1], 0.0):
        client.send(client.see().uid("timeline"), "seek", float(wanted))
        wait_until(lambda due=wanted: shown_time() == pytest.approx(due))
    client.toggle()
    wait_until(lambda: "paused at rest" in status())
    assert 0.0 < shown_time() < times[-1]
    client.toggle()
    client.toggle()
    wait_until(lambda: status().endswith("s: paused"))


def test_a_breakpoint_may_be_named_before_a_replay(recorded, panels):
    page = ReplayPage(Recording(recorded[0]), panels, port=0, breakpoints=("rest", "root"))
    page.close()
    assert page.controls.breakpoints == {"root", "rest"}
    with pytest.raises(BtManipError, match="no node is called 'rust'; did you mean 'rest'"):
        ReplayPage(Recording(recorded[0]), panels, port=0, breakpoints=("rust",))


def test_panels_that_need_a_run_are_left_out(recorded):
    def make(page):
        pytest.fail("it needs a run")

    make.needs_run = True
    ReplayPage(Recording(recorded[0]), {"jog": make}, port=0).close()


def test_the_page_says_that_a_recording_is_incomplete(recorded, panels, tmp_path):
    data, path = recorded[0].read_bytes(), tmp_path / "cut.mcap"
    path.write_bytes(data[: len(data) * 9 // 10])
    with (
        closing(ReplayPage(Recording(path), panels, port=0, start=0.1)) as page,
        closing(Client(page)) as client,
    ):
        assert client.see().find("timeline")["time"] == pytest.approx(0.1)
        assert client.find("status")["text"] == "cycle 1, 0.10 s: paused"
        assert "incomplete: it was cut off after" in client.find("status")["note"]
