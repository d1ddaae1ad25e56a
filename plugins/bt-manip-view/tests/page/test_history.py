"""The past of a run that the page keeps is that of the run's recording, within its memory."""

from itertools import pairwise

import numpy as np
import pytest

from bt_manip.behaviours import MoveToConfiguration, RemoveObject, SpawnObject
from bt_manip.bt import AlwaysFailure, Fallback, Sequence, Sleep
from bt_manip.runner import RunEvent
from bt_manip_recording import CellScene, McapRecorder, RecordedRun, Recording, Timeline
from bt_manip_view.page.history import History
from bt_manip_view.page.keep_panel import KeepPanel

from .conftest import box_called

ROW = np.arange(6.0 * 2 + 3).tobytes()


def status(time, uid, name, old="IDLE"):
    data = {"uid": uid, "path": f"node {uid}", "old": old, "status": name, "reason": ""}
    return RunEvent(time, "status", data)


@pytest.fixture(scope="module")
def source():
    return CellScene(*box_called("thing"), {"thing": object()})


def filled(source, ticks, **options):
    """Return a past in which node 1 begins in even ticks and succeeds in odd ones."""
    past = History(**options)
    past.look(source)
    past.add(status(0.0, 2, "RUNNING"))
    past.end_tick(0.0, source.poses(), {})
    for tick in range(1, ticks + 1):
        past.begin_tick()
        past.add(status(0.01 * (tick - 1), 1, "SUCCESS" if tick % 2 else "RUNNING"))
        poses = source.poses()
        poses[1, 0] = tick
        past.end_tick(0.01 * tick, poses, {"arm": (ROW, True)})
    return past


def shown(events):
    return {event.data["uid"]: event for event in events}


def test_a_full_memory_forgets_the_oldest_states_but_not_what_still_holds(source):
    whole, past = filled(source, 5000), filled(source, 5000, kept_bytes=500_000)
    assert past.size < 500_000 and 100 < len(past.times) < 1000
    assert past.last == whole.last and past.first > 4000
    for index in (past.first, past.first + 1, past.last):
        assert shown(past.events(-1, index)) == shown(whole.events(-1, index))
        past.index = whole.index = index
        np.testing.assert_array_equal(past.poses(), whole.poses())
    middle = (past.first + past.last) // 2
    assert past.events(middle, past.last) == whole.events(middle, past.last)
    assert len(past.joints(0, past.last + 1)[0]) == len(past.times)
    past.seek(0.0)
    assert past.index == past.first


def test_things_are_in_the_past_in_which_they_were(source):
    past = filled(source, 5)
    other = CellScene(*box_called("other"), {"other": object()})
    past.look(other)
    for _ in range(5):
        past.begin_tick()
        past.end_tick(past.times[-1] + 0.01, other.poses(), {"arm": (ROW, True)})
    entities = []
    for index in (5, 6, 10):
        past.index = index
        entities.append(set(past.entities()) - {"world"})
    assert entities == [{"thing"}, {"other"}, {"other"}]
    assert past.frames == ["world", "thing", "other"]
    assert (past.alike(0), past.alike(3), past.alike(6)) == (6, 3, 5)


@pytest.fixture
def saved(page, tmp_path):
    """Give a function that saves the recording of a page's run, as its button does."""
    keep = KeepPanel(page)
    page._panels.append(keep)

    def save():
        name, data = page.site.downloads["/recording.mcap"]()
        (tmp_path / name).write_bytes(data)
        return Recording(tmp_path / name)

    return save


def test_a_saved_recording_has_the_ticks_of_one_that_was_made_during_the_run(
    make_run, page, saved, tmp_path
):
    root = Sequence(
        SpawnObject(object="{cube}"),
        MoveToConfiguration(configuration=[0.1, -0.7, 0.1, -2.3, 0.0, 1.6, 0.8]),
        RemoveObject(object="{cube}"),
        Fallback(AlwaysFailure("never"), Sleep(msec=30)),
    )
    make_run(root, cycles=2).execute([McapRecorder(tmp_path / "run.mcap"), page])
    full, mine = Timeline(Recording(tmp_path / "run.mcap")), Timeline(recording := saved())
    np.testing.assert_array_equal(mine.times, full.times)
    n = len(full.times)
    for before, index in pairwise([-1, *range(0, n, 7), n - 1]):
        kinds = ("contact",)  # not on the page
        expected = [one for one in full.events(before, index) if one.kind not in kinds]
        assert mine.events(before, index) == expected
        mine.scene.index = full.scene.index = index
        assert mine.scene.entities().keys() == full.scene.entities().keys()
        poses = dict(zip(full.scene.frames, full.scene.poses(), strict=True))
        for frame, pose in zip(mine.scene.frames, mine.scene.poses(), strict=True):
            if frame.partition("/")[0] in mine.scene.entities() and index:
                np.testing.assert_allclose(pose, poses[frame], atol=1e-6, err_msg=frame)
    for one, other in zip(
        mine.joints(1, n)[1]["panda"], full.joints(1, n)[1]["panda"], strict=True
    ):
        np.testing.assert_array_equal(one, other)
    assert (
        recording.complete and [c.status for c in RecordedRun(recording).cycles] == ["SUCCESS"] * 2
    )


def test_nothing_is_saved_before_there_is_a_run(page):
    KeepPanel(page)
    assert [make() for make in page.site.downloads.values()] == [None, None]
