"""A run that continues from a snapshot ends like an uninterrupted one, bit for bit."""

import copy
import json
from dataclasses import replace

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.behaviours import Grasp, Hover, Lift, OpenGripper, Reach, SpawnObject
from bt_manip.bt import AlwaysFailure, Parallel, Sequence, Sleep
from bt_manip.cell import PhysicsDiverged
from bt_manip.exceptions import BtManipError
from bt_manip.models import check_downloads
from bt_manip.record.report.recorder import Recorder
from bt_manip.runner import Run, RunObserver, load_snapshot, prepare, request_of, save_snapshot
from bt_manip.scenes import SceneObject, table_and_basket
from bt_manip.spatial import pose
from tests.support.runs import Listener

from .conftest import Snapshots, continued


def make(parts, tree: str = "pick_place") -> Run:
    return prepare(request_of(tree, parts), parts)


def whole(run: Run, **options) -> tuple[str, list[dict]]:
    recorder, snapshots = Recorder("", 0), Snapshots()
    run.execute([recorder, snapshots], **options)
    return recorder.report().state_digest, snapshots.taken


def test_a_run_that_continues_from_a_file_ends_with_the_same_digest(parts, tmp_path):
    digest, snapshots = whole(make(parts))
    for tick in (163, 250, -1):  # around the cube, over the basket, and at the end
        save_snapshot(tmp_path / "tick.json", snapshots[tick])
        assert continued(make(parts), load_snapshot(tmp_path / "tick.json")) == digest


def test_a_run_with_two_robots_continues_from_a_snapshot_while_both_move(parts):
    one, other = (make(parts, "two_arms") for _ in range(2))

    def late(run: Run) -> bool:
        return run.station.cell.time > 1.3

    digest, snapshots = whole(one, stop=lambda: late(one))
    snapshot = snapshots[90]  # each is moving to its first cube
    assert continued(other, snapshot, stop=lambda: late(other)) == digest


def test_a_second_pick_of_an_object_continues_from_a_snapshot(make_run):
    cube = SceneObject("cube", "cube", pose((0.33, 0.05, 0.0)), free=True, on="table")
    scene = replace(table_and_basket(), objects=(*table_and_basket().objects, cube))

    def make():
        steps = [kind(object="cube") for kind in (Reach, Grasp)]
        again = [Lift(height=0.05), OpenGripper(), Hover("again", object="cube")]
        return make_run(Sequence("pick", *steps, *again), scene=scene)

    digest, snapshots = whole(make())
    assert continued(make(), snapshots[round(0.45 * len(snapshots))]) == digest


def test_a_state_does_not_change_while_its_run_goes_on(make_run):
    def work():
        steps = [SpawnObject(object="{o}"), Hover(object="{o}"), AlwaysFailure()]
        return Parallel("both", Sequence(*steps), AlwaysFailure(), success_count=1, failure_count=2)

    run, states, observer = make_run(work()), [], RunObserver()
    observer.after_tick = lambda: states.append((state := run.get_state(), copy.deepcopy(state)))
    run.execute([observer])
    assert len(states) > 10
    assert all(state == copied for state, copied in states)
    taken, copied = states[5]
    run.set_state(taken)
    run.execute()
    assert taken == copied


def test_derived_quantities_of_the_last_step_are_restored_too(parts):
    station = build_station(parts)
    station.cell.add(station.models.create("cube"), pose((0.2, 0.2, 1.04)))
    station.cell.step(3)
    other = build_station(parts)
    other.set_state(json.loads(json.dumps(station.get_state())))
    for field in ("xpos", "qacc", "sensordata", "efc_force", "qfrc_constraint", "ctrl"):
        mine, its = (getattr(s.cell.data, field) for s in (station, other))
        assert mine.tobytes() == its.tobytes(), field
    assert other.cell.contacts.pairs() == station.cell.contacts.pairs()


def test_a_state_goes_on_to_the_last_bit_in_a_station_whose_physics_have_diverged(parts):
    ends = []
    for diverges in (False, True):
        station = build_station(parts)
        start = station.get_state()
        if diverges:
            pick = Sequence("pick", SpawnObject(object="{it}"), Reach(object="{it}"))
            result = station.run(Sequence("grip", pick, Grasp(object="{it}")))
            assert result.status.name == "SUCCESS"
            station.cell.data.qvel[:] = np.nan
            with pytest.raises(PhysicsDiverged):
                station.cell.step(50)
        station.set_state(start)
        station.cell.step(50)
        ends.append(station.cell.state_bytes())
    assert ends[0] == ends[1]


def test_the_random_numbers_of_an_episode_follow_from_seed_and_number_alone(make_run):
    run, drawn = make_run(Sleep("rest", msec=5), seed=2), []
    for seed, episode in ((None, 3), (None, 4), (5, 3), (2, 3)):
        run.begin_episode(episode, seed)
        drawn.append(run.station.rng.random())
    assert drawn[0] == drawn[3] and len({*drawn}) == 3


def test_a_run_that_has_ended_can_be_run_again(make_run):
    run, events = make_run(Sleep(msec=20)), []
    for _ in range(2):
        run.execute([Listener(events, ("cycle",))])
    assert [(event.data["cycle"], event.data["status"]) for event in events] == 2 * [
        (0, "RUNNING"), (0, "SUCCESS")
    ]  # fmt: skip


def test_numbers_are_restored_to_the_last_bit(tmp_path):
    numbers = [0.1, -0.0, 5e-324, 1.7976931348623157e308, float("inf"), 2**127 + 1]
    save_snapshot(tmp_path / "s.json", {"x": numbers, "none": None, "yes": True, "text": "é"})
    back = load_snapshot(tmp_path / "s.json")
    assert repr(back) == repr({"x": numbers, "none": None, "yes": True, "text": "é"})


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ({"a": [1, {"b": np.zeros(3)}]}, "a ndarray at '/a/1/b'"),
        ({"a": {3: 1}}, "the key 3 at '/a'"),
        ({"a": b"x"}, "a bytes at '/a'"),
    ],
)
def test_other_than_plain_data_is_refused_and_leaves_no_file(tmp_path, state, message):
    with pytest.raises(BtManipError, match=message):
        save_snapshot(tmp_path / "s.json", state)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "cannot read"),
        ("{", "is no snapshot"),
        ("[]", "is no snapshot"),
        ("[" * 100_000, "nested too deep"),
        ('{"format": "bt-manip snapshot", "version": 7}', "it has no table 'state'"),
        ('{"format": "bt-manip snapshot", "version": 7, "state": {"a": NaN}}', "is NaN"),
        ('{"format": "bt-manip snapshot", "version": 99}', "version 99, expected 7"),
    ],
)
def test_a_file_that_is_not_a_snapshot_is_refused(tmp_path, content, message):
    if content is not None:
        (tmp_path / "s.json").write_text(content)
    with pytest.raises(BtManipError, match=message):
        load_snapshot(tmp_path / "s.json")
    with pytest.raises(BtManipError, match="cannot write"):
        save_snapshot(tmp_path / "no" / "s.json", {})


def test_a_snapshot_that_was_edited_is_refused(tmp_path):
    path = tmp_path / "s.json"
    save_snapshot(path, {"a": [1.0, 2.0]})
    path.write_text(path.read_text().replace("2.0", "3.0"))
    with pytest.raises(BtManipError, match="is damaged"):
        load_snapshot(path)


@pytest.mark.parametrize("checks", [True, False])
def test_a_snapshot_downloads_nothing(parts, checks):
    """Sources that do not promise to check this are not even asked."""
    asked = []

    def find(address, progress):
        asked.append(address)
        check_downloads(address)

    find.checks_downloads = checks
    parts = replace(parts, model_sources=parts.model_sources.with_part("shelf", find))
    station = build_station(parts)
    state = station.get_state()
    last = state["cell"]["entities"][-1]
    state["cell"]["entities"][-1] = {**last, "name": "x", "kind": "shelf:mug"}
    words = "a snapshot downloads no models, and 'shelf:mug' is not here" if checks else "unknown"
    with pytest.raises(BtManipError, match=words):
        station.set_state(state)
    assert asked == ["shelf:mug"] * checks


def test_a_state_that_is_not_finite_or_of_another_size_is_refused(parts):
    station = build_station(parts)
    for wrong in ([0.0], "x", [[1.0], [2.0, 3.0]], None):
        state = station.get_state()
        state["cell"]["integration"] = wrong
        with pytest.raises(BtManipError, match="does not fit this cell"):
            station.set_state(state)
    state = station.get_state()
    state["cell"]["integration"][3] = float("nan")
    with pytest.raises(BtManipError, match="a number of the state is not finite"):
        station.set_state(state)
