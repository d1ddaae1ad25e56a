"""The page of a run is one HTML file that shows the figures of the run and loads nothing."""

import json
import re
from base64 import b64decode

import msgspec
import pytest
import zstandard
from lxml import html

from bt_manip.bt import AlwaysFailure, Fallback, Sequence, Sleep
from bt_manip.cli import Interrupt, run_app
from bt_manip_recording import McapRecorder, RecordedRun, Recording
from bt_manip_view import run_page
from bt_manip_view.html.plots import Plots

HOSTILE = "</script><script>alert(1)</script>"
MARKUP = "<img src=x onerror=alert(2)>'\"&amp;"


@pytest.fixture(scope="module")
def text(picked) -> str:
    return run_page(Recording(picked))


@pytest.fixture(scope="module")
def page(text):
    return html.document_fromstring(text)


def shown(page) -> str:
    return " ".join(page.find("body").find("main").text_content().split())


def test_the_report_identifies_the_run(page, picked):
    assert page.find(".//h1").text_content() == "pick_place SUCCESS"
    lines = [one.text_content() for one in page.findall(".//dl/*")]
    facts = dict(zip(lines[::2], lines[1::2], strict=True))
    identity = Recording(picked).identity
    assert facts["tree"] == "pick_place" and facts["seed"] == "0" and facts["robot"] == "panda"
    assert facts["scene"] == "table_and_basket" and facts["controller"] == "computed_torque"
    assert facts["versions: mujoco"] == identity["versions"]["mujoco"]
    assert facts["sha256: pick_place.xml"] == identity["sha256"]["pick_place.xml"]


def test_figures_are_those_of_the_json_report(page, picked):
    report = json.loads(picked.with_suffix(".json").read_text())
    rows = page.xpath("//section[h2='Cycles']//tr[td]")
    for row, cycle in zip(rows, report["cycles"], strict=True):
        _, status, _, duration, error, velocity, acceleration, torque, _ = (
            cell.text_content() for cell in row
        )
        assert status == cycle["status"]
        assert duration == f"{cycle['duration_s']:.2f} s"
        assert error == f"{cycle['max_tracking_error_rad'] * 1e3:.2f} mrad"
        limits = [cycle["limits"][name] for name in ("velocity", "acceleration", "effort")]
        assert [velocity, acceleration, torque] == [f"{use:.0%}" for use in limits]
    assert "2 of 2cycles succeeded" in shown(page)


def test_reasons_of_failed_nodes_are_listed(page):
    rows = [row.text_content() for row in page.xpath("//section[starts-with(h2,'Reasons')]//tr")]
    assert any("IsHolding" in row and "the gripper holds nothing" in row for row in rows)


def test_nothing_is_loaded_from_elsewhere(page):
    (player,) = page.findall(".//iframe")
    for document in (page, html.document_fromstring(player.get("srcdoc"))):
        for element in document.iter():
            for name in ("src", "href", "action", "data"):
                assert (element.get(name) or "data:").startswith("data:"), element.tag
    assert "__VISER_EMBED_DATA__" in player.get("srcdoc")


def test_the_label_of_the_replay_names_time_and_running_leaf(page):
    player = page.find(".//iframe").get("srcdoc")
    (data,) = re.findall(r'__VISER_EMBED_DATA__="([^"]+)"', player)
    unpacked = zstandard.ZstdDecompressor().decompressobj().decompress(b64decode(data)[8:])
    length = int.from_bytes(unpacked[:8], "little")
    messages = msgspec.msgpack.decode(unpacked[8 : 8 + length])["messages"]
    labels = {
        round(time, 2): message["updates"]["text"]
        for time, message in messages
        if message.get("name") == "/running" and "text" in message.get("updates", {})
    }
    assert labels[0.25] == "0.25 s  Hover"
    assert labels[1.0] == "1.00 s  Reach"
    assert labels[3.0] == "3.00 s  Drop"


def test_lines_reach_the_largest_tracking_error(picked):
    run = RecordedRun(Recording(picked))
    robot = run.robots["panda"]
    lines = Plots(run, 0.0).lines("[mrad]", robot.t, 1e3 * robot.error, robot.joints).renderers
    found = [line.data_source.data["y"] for line in lines if "y" in line.data_source.data]
    largest = max(abs(values).max() for values in found)
    assert largest == pytest.approx(1e3 * abs(robot.error).max(), rel=1e-6)


def test_text_of_the_recording_stays_text(make_run, tmp_path):
    root = Sequence(
        HOSTILE,
        Fallback(MARKUP, AlwaysFailure("<b>no</b>"), Sleep("$$\\frac{1}{2}$$", msec=20)),
        AlwaysFailure(HOSTILE),
    )
    run = make_run(root)
    run.execute([McapRecorder(tmp_path / "run.mcap")])
    page = html.document_fromstring(run_page(Recording(tmp_path / "run.mcap")))
    assert not page.findall(".//img")
    assert all("alert" not in (script.text or "")[:100] for script in page.iter("script"))
    names = [row.text_content() for row in page.find_class("names")[0]]
    assert names[:2] == [HOSTILE, MARKUP]
    assert page.find(".//h1").text_content() == "test FAILURE"
    with_player = html.document_fromstring(page.find(".//iframe").get("srcdoc"))
    assert all((script.text or "") != "alert(1)" for script in with_player.iter("script"))


def test_an_incomplete_recording_gives_a_report_that_says_so(picked, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(picked.read_bytes()[: picked.stat().st_size * 3 // 4])  # in the second cycle
    text = shown(html.document_fromstring(run_page(Recording(cut))))
    assert "This recording is incomplete" in text and "NOT ENDED" in text


@pytest.mark.soak
def test_a_minute_is_thinned_below_five_megabytes(tmp_path):
    path = tmp_path / "minute.mcap"
    command = ["run", "pick_place", "--cycles", "16", "--quiet", "--record", str(path)]
    assert run_app(Interrupt(), command) == 0
    recording = Recording(path)
    assert recording.end > 60.0
    assert len(run_page(recording).encode()) <= 5e6
