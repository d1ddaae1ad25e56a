"""Runs that are chosen on the page are the runs of the command line."""

import json
import time
from dataclasses import replace

import pytest
from bt_manip.cli.page_session import SAVED, PageSession
from bt_manip.viewer.page import RunChoice

from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.run_options import RunOptions

MOVE = """
<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <Sequence><MoveToConfiguration configuration="0;-0.7;0;-2.2;0;1.6;0.8"/></Sequence>
  </BehaviorTree>
</root>
"""
SAVED_MOVE = MOVE.replace("0;-0.7;0;-2.2;0;1.6;0.8", "above")


@pytest.fixture
def tree(tmp_path):
    path = tmp_path / "tree.xml"
    path.write_text(MOVE)
    return str(path)


@pytest.fixture
def session(tree, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = RunOptions(tree=tree, real_time=0.0, view=True, quiet=True)
    session = PageSession(options, Interrupt())
    with session._interrupt.held():
        session.prepare()
        yield session
    session.close()


@pytest.fixture
def serve(session):
    """Serve the page to somebody who asks for one thing after the other, then leave."""

    def serve(*asked):
        steps = [step for one in asked for step in (one, None)]

        def take():
            if not steps:
                session._interrupt.requested = True
                return None
            step = steps.pop(0)
            if callable(step):
                step()
                return None
            return step

        session._panel.take = take
        session.serve()
        session._interrupt.requested = False

    return serve


def choice(tree, scene="table_and_basket", robot="panda", seed=0, cycles=1):
    return RunChoice(tree, scene, robot, seed, cycles)


def jog(session, joint, value, ticks=100):
    """Ask for a joint position as the slider does, and let the cell live."""
    robot = session._jog._robots[0]
    robot.requests["joint", joint] = lambda: robot._move_joint(joint, value)
    for _ in range(ticks):
        session._idle_tick()


def test_a_run_after_jogging_and_reset_has_the_digest_of_the_command_line(
    session, serve, tree, tmp_path, bt_manip
):
    report = tmp_path / "report.json"
    assert bt_manip("run", tree, "--report", report, "--seed", "3").code == 0
    expected = json.loads(report.read_text())["state_digest"]
    chosen = choice(tree, seed=3)
    serve(("run", chosen))
    assert session.last.report.state_digest == expected
    serve(lambda: jog(session, 0, 0.4), ("reset", chosen), ("run", chosen))
    assert session.last.report.state_digest == expected


def test_a_run_begins_where_the_arm_was_jogged(session, serve, tree):
    before = session._station
    serve(lambda: jog(session, 0, 0.4), ("run", choice(tree)))
    assert session.last.run.station is before
    assert session.last.report.status == "SUCCESS"
    assert session.last.report.state_digest


def test_a_jogged_arm_is_at_home_after_a_reset(session, serve, tree):
    serve(lambda: jog(session, 0, 0.4))
    assert session._station.robot.q[0] > 0.1
    serve(("reset", choice(tree)))
    assert abs(session._station.robot.q[0]) < 1e-3


def test_another_scene_or_robot_is_shown_at_once(session, serve, tree):
    serve(("show", choice(tree, scene="two_arms")))
    assert list(session._station.robots) == ["left", "right"]


def test_the_same_cell_is_kept_when_another_tree_is_chosen(session, serve):
    before = session._station
    serve(("show", choice("pick_place")))
    assert session._station is before


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"tree": "no.xml"}, "no tree file"),
        ({"scene": "no_scene"}, "unknown scene"),
        ({"robot": "no_robot"}, "unknown robot"),
        ({"scene": "two_arms"}, "left"),
    ],
)
def test_a_mistake_is_shown_and_the_session_goes_on(session, serve, tree, wrong, message):
    serve(("run", choice(tree)._replace(**wrong)))
    assert message in session._panel._message.content
    serve(("reset", choice(tree)), ("run", choice(tree)))
    assert session.last.report.status == "SUCCESS"
    assert not session._panel._message.content


def test_an_exception_of_a_behaviour_is_shown_and_the_session_goes_on(
    session, serve, trees, tree, capfd
):
    serve(("run", choice(f"{trees}:loud")))
    assert "so loud" in session._panel._message.content
    serve(("run", choice(tree)))
    assert session.last.report.status == "SUCCESS"
    capfd.readouterr()


def test_a_saved_configuration_can_be_named_by_the_next_tree(session, serve, tmp_path, bt_manip):
    tree = tmp_path / "saved.xml"
    tree.write_text(SAVED_MOVE)

    def save():
        robot = session._jog._robots[0]
        robot.requests["save"] = lambda: robot._save_as("above")

    serve(lambda: jog(session, 0, 0.4, ticks=200), save)
    assert (tmp_path / SAVED).is_file()
    assert str(tmp_path / SAVED) in session._jog._message.content
    serve(("reset", choice(str(tree))), ("run", choice(str(tree))))
    assert session.last.report.status == "SUCCESS"
    assert session._station.robot.q[0] == pytest.approx(0.4, abs=2e-3)
    assert bt_manip("run", tree, "--configurations", SAVED).code == 0


def test_configurations_can_be_saved_in_a_new_file(session, serve, tree, tmp_path):
    file = tmp_path / "new.toml"
    session._options = replace(session._options, configurations=file)
    serve(("run", choice(tree)))
    assert session.last.report.status == "SUCCESS"
    robot = session._jog._robots[0]
    serve(lambda: robot.requests.update(save=lambda: robot._save_as("here")))
    assert "here = [" in file.read_text()


def test_a_cell_that_raises_stands_still_until_the_next_request(session, serve, tree, monkeypatch):
    def fail(*_, **__):
        raise ValueError("the physics diverged")

    monkeypatch.setattr(session._station.cell, "step", fail)
    start = time.perf_counter()
    serve(*[None] * 20)
    assert time.perf_counter() - start > 0.3  # 40 ticks in real time, not as fast as possible
    assert "the physics diverged" in session._panel._message.content
    serve(("reset", choice(tree)))
    assert session._station.cell.time > 0.0


def test_a_plugin_that_exits_does_not_end_the_session(session, serve, tree, monkeypatch):
    def leave(*_, **__):
        raise SystemExit("no license")

    monkeypatch.setattr("bt_manip.runner.prepare_station", leave)
    serve(("reset", choice(tree)))
    assert "SystemExit: no license" in session._panel._message.content
    monkeypatch.setattr(session._station.cell, "step", leave)
    serve(None)
    assert "stands still: no license" in session._panel._message.content


def test_an_interrupt_ends_a_page_whose_cell_hangs(session, serve, monkeypatch):
    def hang(*_, **__):
        session._interrupt._signalled(2, None)
        time.sleep(60.0)

    monkeypatch.setattr("bt_manip.cli.interrupt.PATIENCE", 0.2)
    monkeypatch.setattr(session._station.cell, "step", hang)
    start = time.perf_counter()
    serve(None)
    assert time.perf_counter() - start < 30.0


def test_an_interrupt_while_a_cell_is_built_ends_the_session(session, serve, tree, monkeypatch):
    def interrupted(*_):
        session._interrupt._signalled(2, None)

    monkeypatch.setattr("bt_manip.runner.prepare_station", interrupted)
    with pytest.raises(KeyboardInterrupt):
        serve(("reset", choice(tree)))
    session._interrupt.requested = False
