"""Runs that are chosen on the page are the runs of the command line."""

import json
import re
import shlex
import signal
import time
from collections import deque
from dataclasses import replace
from pathlib import Path

import pytest

from bt_manip.cli import RunOptions, Session
from bt_manip_view.page.session_panel import RunChoice, SessionPanel

from ..page.conftest import Client

SAVED = Path("configurations.toml")

TARGET = "0;-0.7;0;-2.2;0;1.6;0.8"


@pytest.fixture
def tree(task):
    return str(task(f'<MoveToConfiguration configuration="{TARGET}"/>'))


class Visit(Session):
    """A session that does a step before each tick between runs, and ends after the last one."""

    steps: deque = deque()

    @property
    def interrupted(self):
        if super().interrupted or not self.steps:
            return True
        step = self.steps.popleft()
        if step is not None:
            step()
        return False


@pytest.fixture
def options(tree):
    return RunOptions(tree=tree, real_time=0.0, quiet=True, views={"view": {"port": 0}})


@pytest.fixture
def session(options, interrupt, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    session = Visit(options, interrupt)
    with interrupt.held():
        session.show()
        yield session
    session.close()


@pytest.fixture
def user(session):
    """Open the page."""
    client = Client(session.views["view"])
    yield client
    client.close()


@pytest.fixture
def serve(session, monkeypatch):
    """Serve the page to somebody who asks for one thing after the other, then leave."""
    asked = deque(maxlen=1)
    monkeypatch.setattr(SessionPanel, "take", lambda _: asked.pop() if asked else None)

    def serve(*steps):
        calls = [
            step if callable(step) or step is None else lambda step=step: asked.append(step)
            for step in steps
        ]
        session.steps = deque([None, *(one for call in calls for one in (call, None))])
        session.serve()

    return serve


def choice(tree, scene="table_and_basket", robot="panda", seed=0, cycles=1):
    return RunChoice(tree, scene, robot, seed, cycles)


WHILE = (None,) * 50
"""Ticks in which the arm comes to the end of a motion."""


def test_a_run_begins_where_the_arm_was_jogged_and_after_a_reset_is_that_of_the_command_line(
    session, serve, user, tree, tmp_path, bt_manip
):
    report = tmp_path / "report.json"
    assert bt_manip("run", tree, "--report", report, "--seed", "3").code == 0
    expected = json.loads(report.read_text())["state_digest"]
    chosen = choice(tree, seed=3)
    serve(("run", chosen))
    assert session.last.report.state_digest == expected
    before = session.station
    serve(lambda: user.set("slider", "joint1 [rad]", 0.4), *WHILE, ("run", chosen))
    assert session.last.run.station is before
    assert session.last.report.status == "SUCCESS"
    result = user.see().find("result")
    assert "began where the arm was jogged" in result["text"]  # no command repeats it
    serve(("reset", chosen), ("run", chosen))
    assert session.last.report.state_digest == expected


SPAWN = """
<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence>
  <SpawnObject region="0.3;0.5;-0.2;0.2" object="{cube}"/><Sleep msec="{wait}"/>
</Sequence></BehaviorTree>
<TreeNodesModel><SubTree ID="Main"><input_port name="wait" default="30"/></SubTree></TreeNodesModel>
</root>
"""


def test_the_command_of_the_result_repeats_the_run(
    session, serve, user, tmp_path, bt_manip, monkeypatch
):
    tree = tmp_path / "my tree.xml"
    tree.write_text(SPAWN)
    session.options = replace(
        session.options, tree=str(tree), tick_ms=20.0, settings={"wait": "70"}, tool_speed=0.3
    )
    chosen = choice(str(tree), scene="two_arms", seed=4, cycles=2)
    serve(("reset", chosen), ("run", chosen))
    digest = session.last.report.state_digest
    result = user.see().find("result")
    (command,) = re.findall("bt-manip (run .* --record run.mcap)", result["text"])
    assert bt_manip(*shlex.split(command), "--quiet", "--report", "kept.json").code == 0
    assert json.loads(Path("kept.json").read_text())["state_digest"] == digest
    assert Path("run.mcap").exists()


def test_the_cell_changes_at_once_where_the_chosen_tree_or_scene_needs_another(
    session, serve, tree
):
    before = session.station
    serve(("show", choice("pick_place")))
    assert session.station is before
    serve(("show", choice(tree, scene="two_arms")))
    assert list(session.station.robots) == ["left", "right"]


MISTAKES = (
    ({"tree": "no.xml"}, "no tree file"),
    ({"scene": "no_scene"}, "unknown scene"),
    ({"robot": "no_robot"}, "unknown robot"),
    ({"scene": "two_arms"}, "left"),
)


def test_mistakes_and_exceptions_are_shown_and_the_session_goes_on(
    session, serve, user, trees, tree, capfd
):
    for wrong, message in MISTAKES:
        serve(("run", choice(tree)._replace(**wrong)))
        assert message in user.text()
    serve(("run", choice(f"{trees}:loud")))
    assert "so loud" in user.text()
    serve(("reset", choice(tree)), ("run", choice(tree)))
    assert session.last.report.status == "SUCCESS"
    assert 'class="error"' not in user.text()
    capfd.readouterr()


def save(user, name):
    user.set("text", "Save as", name)
    user.press("Save configuration")


def test_a_saved_configuration_can_be_named_by_the_next_tree_also_in_a_new_file(
    session, serve, user, tree, tmp_path, bt_manip
):
    saved, file = tmp_path / "saved.xml", tmp_path / "new.toml"
    saved.write_text(Path(tree).read_text().replace(TARGET, "above"))
    serve(
        lambda: user.set("slider", "joint1 [rad]", 0.4), *WHILE, *WHILE, lambda: save(user, "above")
    )
    assert (tmp_path / SAVED).is_file()
    assert str(tmp_path / SAVED) in user.text()
    serve(("run", choice(str(saved))))
    assert session.last.report.status == "SUCCESS"
    serve(("reset", choice(str(saved))), ("run", choice(str(saved))))
    assert session.last.report.status == "SUCCESS"
    assert session.station.robot.q[0] == pytest.approx(0.4, abs=2e-3)
    assert bt_manip("run", saved, "--configurations", SAVED).code == 0
    session.options = replace(session.options, configurations=file)
    serve(("run", choice(tree)), lambda: save(user, "here"))
    assert session.last.report.status == "SUCCESS"
    assert "here = [" in file.read_text()


def test_a_cell_that_raises_or_exits_stands_still_until_the_next_request(
    session, serve, user, tree, monkeypatch
):
    def fail(*_, **__):
        raise ValueError("the physics diverged")

    def leave(*_, **__):
        raise SystemExit("no license")

    monkeypatch.setattr(session.station.cell, "step", fail)
    start = time.perf_counter()
    serve(*[None] * 20)
    assert time.perf_counter() - start > 0.3  # 40 ticks in real time, not as fast as possible
    assert "the physics diverged" in user.text()
    serve(("reset", choice(tree)))
    assert session.station.cell.time > 0.0
    monkeypatch.setattr(session.plugins.parts.controllers, "get", leave)
    serve(("reset", choice(tree)))
    assert "SystemExit: no license" in user.text()
    monkeypatch.setattr(session.station.cell, "step", leave)
    serve(None)
    assert "stands still: no license" in user.text()


def test_an_interrupt_ends_a_page_whose_cell_hangs(session, serve, monkeypatch):
    def hang(*_, **__):
        signal.raise_signal(signal.SIGINT)
        time.sleep(60.0)

    monkeypatch.setattr(session.station.cell, "step", hang)
    start = time.perf_counter()
    serve(None)
    assert time.perf_counter() - start < 30.0


def test_an_interrupt_while_a_cell_is_built_ends_the_session(session, serve, tree, monkeypatch):
    def interrupted(*_):
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(session.plugins.parts.controllers, "get", interrupted)
    with pytest.raises(KeyboardInterrupt):
        serve(("reset", choice(tree)))
