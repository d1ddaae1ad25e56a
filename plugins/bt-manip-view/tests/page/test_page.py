"""A run on the page is the same run: the page shows it, and pauses it on request."""

import io
import threading
import time

import numpy as np
import pytest
import trimesh

from bt_manip.behaviours import IsHolding, MoveHome, RemoveObject, SpawnObject
from bt_manip.bt import AlwaysFailure, Fallback, Script, Sequence, Sleep
from bt_manip.exceptions import BtManipError
from bt_manip.runner import Run
from bt_manip_recording import CellScene
from bt_manip_view import Page
from bt_manip_view.page.scene import SceneView

from .conftest import box_called, wait_until


def picking():
    return Sequence(
        "root",
        SpawnObject(object="{cube}"),
        Sleep(msec=50),
        MoveHome(),
        RemoveObject(object="{cube}"),
    )


def of_type(messages, kind):
    return [message for message in messages if message["type"] == kind]


def test_the_visible_geometry_is_sent_once_with_its_textures_and_the_poses(make_run, page, connect):
    client = connect()
    make_run(picking()).execute([page])
    messages = client.read()
    names = [message["name"] for message in of_type(messages, "MeshMessage")]
    assert any(name.startswith("/panda/") for name in names)
    assert any(name.startswith("/table") for name in names)
    assert len(set(names)) == len(names)
    moved = {message["name"] for message in of_type(messages, "SetPositionMessage")}
    assert any(name.startswith("/panda/") for name in moved)
    sent = {m["name"]: m["props"]["glb_data"] for m in of_type(messages, "GlbMessage")}
    data = next(data for name, data in sent.items() if name.startswith("/table/"))
    (top,) = trimesh.load(io.BytesIO(data), file_type="glb").geometry.values()
    pixels = np.asarray(top.visual.material.baseColorTexture)
    assert pixels.shape == (256, 256, 3) and pixels.std() > 3.0
    assert top.visual.uv.shape == (24, 2)
    assert top.extents.tolist() == pytest.approx([1.5, 0.8, 0.03])


def test_no_two_nodes_have_the_same_name_in_turn(page, connect):
    """A page would keep the pose of the first, and so would the replay of a report."""
    client, view, box = connect(), SceneView(page.server), box_called("thing")
    for number in range(3):
        view.bind(CellScene(*box, {"thing": number}))
    created = [m["name"] for m in of_type(client.read(), "FrameMessage")]
    assert "/thing" in created and len(set(created)) == len(created)


def test_only_changed_poses_are_sent_when_objects_come_and_go(page, connect):
    view, (model, data) = SceneView(page.server), box_called("thing")
    view.bind(CellScene(model, data))
    client = connect()
    client.read()
    data.xpos[1, 0] = 1.0
    for _ in range(2):
        view.bind(CellScene(model, data))
    (moved,) = of_type(client.read(), "SetPositionMessage")
    assert moved["name"] == "/thing/thing" and moved["position"] == [1.0, 0.0, 0.0]


def test_a_page_that_nobody_has_opened_is_drawn_once_at_the_end(make_run, page, monkeypatch):
    calls = []
    for name in ("bind", "update"):
        shown = getattr(SceneView, name)
        monkeypatch.setattr(
            SceneView, name, lambda *args, shown=shown, n=name: (calls.append(n), shown(*args))
        )
    make_run(picking(), cycles=2).execute([page])
    assert calls == ["bind", "update", "update"]  # `bind` updates, too


def test_the_log_says_what_leaves_did_with_a_kind_of_their_own_for_conditions(
    make_run, page, connect
):
    wrong = Fallback("root", IsHolding("holding", object="cube"), Sleep("rest", msec=30))
    spawn = SpawnObject("spawn", object="{cube}")
    make_run(Sequence("all", spawn, wrong, AlwaysFailure("never"))).execute([page])
    lines = connect("page").see().find("log")["lines"]
    kinds = {text.split(":")[0]: kind for _, kind, text, _ in lines}
    assert kinds["spawn"] == "success" and kinds["never"] == "failure"
    assert kinds["cycle 1 failed"] == "error"
    (said,) = (text for _, _, text, _ in lines if text.startswith("spawn: "))
    assert "cube" in said.removeprefix("spawn: ")
    assert {kind for _, kind, text, _ in lines if text.startswith("holding")} == {"condition"}


def test_a_page_that_is_opened_later_shows_the_last_state_as_data_not_as_html(
    make_run, page, connect
):
    rest = Sequence(Script(code="x := 5"), Sleep("rest", msec=50))
    make_run(Fallback("<b>root</b>", AlwaysFailure("never"), rest)).execute([page])
    client = connect("page").see()
    status = client.find("status")
    assert status["text"] == "cycle 1, 0.06 s: ended SUCCESS" and status["look"] == "SUCCESS"
    samples = client.find("plot")["samples"]  # of the tracking error
    assert [row[0] for row in samples] == pytest.approx([0.01, 0.02, 0.03, 0.04, 0.05, 0.06])
    assert client.find("tree")["nodes"][0]["name"] == "<b>root</b>"
    assert client.find("blackboard")["values"]["x"] == "5"
    assert not any("root" in one["content"] for one in client.elements.values() if "content" in one)


def test_the_clock_stands_still_after_a_run_and_that_of_a_second_one_begins_at_zero(
    make_run, page, connect
):
    run = make_run(Sleep("rest", msec=50))
    run.execute([page])
    page.begin_idle(run.station)
    run.station.cell.step(100)
    page.refresh(now=True)
    client = connect("page")
    assert "0.06 s" in client.see().find("status")["text"]
    Run(run.request, run.tree, run.station).execute([page])
    assert client.see().find("status")["text"] == "cycle 1, 0.06 s: ended SUCCESS"
    line = client.find("timeline")
    assert (line["start"], line["end"]) == pytest.approx((0.0, 0.06))
    leaf = next(time for time, uid, name, _ in line["leaves"] if name == "rest")
    assert leaf == pytest.approx(0.0)
    assert client.find("plot")["samples"][0][0] == pytest.approx(0.01)
    (_, _, start, end) = next(iter(client.find("tree")["states"].values()))
    assert (start, end) == pytest.approx((0.0, 0.05), abs=0.011)


def test_the_wait_for_a_browser_ends_when_there_is_none(page):
    start = time.monotonic()
    assert not page.wait_until_open(0.2, lambda: False)
    assert not page.wait_until_open(100.0, lambda: True)
    assert time.monotonic() - start < 20.0


@pytest.fixture
def in_thread(make_run, page):
    """Execute a run with the page in another thread; return the run and the thread."""
    threads = []

    def start(root, stop=lambda: False, **request):
        run = make_run(root, **request)
        thread = threading.Thread(target=lambda: run.execute([page], stop=stop))
        threads.append(thread)
        thread.start()
        return run, thread

    yield start
    page.controls.stopped = True
    for thread in threads:
        thread.join(30)


def test_a_paused_run_stands_still_and_makes_single_ticks(in_thread, client):
    client.toggle()
    run, thread = in_thread(Sleep("rest", msec=100))
    time.sleep(0.3)
    assert run.station.cell.time == 0.0
    for tick in (1, 2):
        client.press("Step")
        wait_until(lambda due=tick * 0.01: run.station.cell.time > due - 1e-9)
        time.sleep(0.2)
        assert run.station.cell.time == pytest.approx(tick * 0.01)
    client.toggle()
    thread.join(30)
    assert run.station.cell.time >= 0.1


def test_breakpoints_pause_after_the_tick_in_which_their_node_starts(in_thread, page, client):
    page.controls.breakpoints = frozenset(["second", "third"])
    leaves = [Sleep(name, msec=50) for name in ("first", "second", "third")]
    run, thread = in_thread(Sequence("root", leaves))
    for node, due in (("second", 0.06), ("third", 0.11)):
        wait_until(lambda: page.controls.paused)
        time.sleep(0.2)
        assert run.station.cell.time == pytest.approx(due)
        assert client.see().find("status")["text"].endswith(f"s: paused at {node}")
        assert thread.is_alive()
        client.press("Continue")
    thread.join(30)
    assert run.station.cell.time >= 0.15


def test_ticks_that_were_asked_for_are_not_made_by_the_next_run(in_thread, page, client):
    client.toggle()
    for _ in range(10):
        client.press("Step")
    _, thread = in_thread(Sleep("rest", msec=20))
    thread.join(30)
    page.controls.breakpoints = frozenset(["rest"])
    run, _ = in_thread(Sleep("rest", msec=20))
    wait_until(lambda: page.controls.paused)
    time.sleep(0.3)
    assert page.controls.paused and run.station.cell.time == pytest.approx(0.01)


@pytest.mark.parametrize("speed", [float("nan"), float("inf"), -1.0], ids=str)
def test_a_speed_that_is_no_positive_number_is_refused(speed):
    with pytest.raises(BtManipError, match="speed must be a positive number"):
        Page(port=0, speed=speed)


@pytest.mark.parametrize("is_open", [False, True])
def test_a_paused_run_ends_at_an_interrupt_and_when_it_is_stopped(
    in_thread, page, connect, is_open
):
    client = connect("page") if is_open else None
    page.controls.paused = True
    interrupted = threading.Event()
    run, thread = in_thread(Sleep("rest", msec=100), stop=interrupted.is_set, cycles=0)
    time.sleep(0.1)
    assert thread.is_alive()
    if client is None:
        interrupted.set()
    else:
        client.press("Stop")
    thread.join(30)
    assert not thread.is_alive() and run.station.cell.time < 0.02
    assert page.stopped == is_open
