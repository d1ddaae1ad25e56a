"""Log files have the header, the schema and the rows of those of BehaviorTree.CPP."""

import itertools
import os
import sqlite3
import struct
from contextlib import closing
from pathlib import Path

import pytest

from bt_manip.bt import NodeStatus, Sequence, Sleep, Tree, instance_to_xml
from bt_manip.exceptions import BtManipError
from bt_manip.record import RecordingError
from bt_manip.runner import RunObserver
from bt_manip_groot.log_files import BtlogRecorder, SqliteRecorder
from bt_manip_recording import McapRecorder
from tests.support.recorded import coming_and_going

from .conftest import run_of, sample_tree


def read_btlog(path):
    """Give magic, XML, start and rows of a .btlog."""
    data = path.read_bytes()
    (length,) = struct.unpack_from("<i", data, 19)
    xml = data[23 : 23 + length].decode()
    (start,) = struct.unpack_from("<q", data, 23 + length)
    rows = data[31 + length :]
    assert len(rows) % 9 == 0
    return data[:19], xml, start, [
        (int.from_bytes(rows[i : i + 6], "little"), *struct.unpack_from("<HB", rows, i + 6))
        for i in range(0, len(rows), 9)
    ]  # fmt: skip


def read_database(path, query):
    with closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as database:
        return database.execute(query).fetchall()


@pytest.fixture(scope="module")
def logs(station, groot2, tmp_path_factory):
    """Log the 40 ticks of the sample tree; give both files."""
    folder = tmp_path_factory.mktemp("logs")
    document = (groot2 / "demo.xml").read_text()
    tree, ticks = sample_tree(document), itertools.count(1)
    paths = folder / "demo.btlog", folder / "demo.db3"
    paths[1].write_text("an older file")

    def intervene() -> None:  # as Groot2 did when the sample was logged
        status = {11: NodeStatus.FAILURE, 14: NodeStatus.SUCCESS}.get(next(ticks))
        tree.node("work").set_tick_hooks(status and (lambda node: status))

    groot = RunObserver()
    groot.before_tick = intervene
    observers = groot, BtlogRecorder(paths[0]), SqliteRecorder(paths[1])
    run_of(station, tree, cycles=11, tick=0.1).execute(observers)
    assert read_btlog(paths[0])[1] == instance_to_xml(tree)
    return paths


def test_a_btlog_is_that_of_the_engine(logs, groot2):
    magic, _, start, rows = read_btlog(logs[0])
    other_magic, _, _, other_rows = read_btlog(groot2 / "demo.btlog")
    assert magic == other_magic
    assert [row[1:] for row in rows] == [row[1:] for row in other_rows]
    assert [row[0] for row in rows] == sorted(row[0] for row in rows)
    assert rows[0][0] == 0 and rows[-1][0] == 3_900_000
    assert start > 1_700_000_000_000_000


def test_a_database_is_that_of_the_engine(logs, groot2):
    databases = logs[1], groot2 / "demo.db3"
    theirs = databases[1]
    schema = "SELECT name, sql FROM sqlite_master WHERE type = 'table' ORDER BY name"
    texts = [[(n, "".join(sql.split())) for n, sql in read_database(p, schema)] for p in databases]
    assert texts[0] == texts[1]
    nodes = "SELECT * FROM Nodes ORDER BY node_uid"
    assert read_database(logs[1], nodes) == read_database(theirs, nodes)
    rows = "SELECT session_id, node_uid, state, extra_data FROM Transitions ORDER BY timestamp"
    assert read_database(logs[1], rows) == read_database(theirs, rows)
    running = "SELECT node_uid, state, duration FROM Transitions WHERE duration > 0 LIMIT 6"
    ours, other = read_database(logs[1], running), read_database(theirs, running)
    for one, wanted in zip(ours, other, strict=True):
        assert one[:2] == wanted[:2]
        assert one[2] == pytest.approx(wanted[2], abs=20_000)
    (definition,) = read_database(logs[1], "SELECT session_id, date, xml_tree FROM Definitions")
    assert definition[0] == 1 and definition[2] == read_btlog(logs[0])[1]


def test_a_log_ends_when_the_tree_is_replaced(station, tmp_path):
    tree = Tree(Sequence(Sleep(msec=20)))

    class Replace(BtlogRecorder):
        """Replaces the tree by a larger one."""

        def cycle_started(self, cycle):
            super().cycle_started(cycle)
            if cycle == 1:
                tree.replace(Tree(Sequence(Sleep(msec=20), Sleep(msec=20))))

    run_of(station, tree, cycles=2).execute([Replace(tmp_path / "a.btlog")])
    assert {row[1] for row in read_btlog(tmp_path / "a.btlog")[3]} == {1, 2}


@pytest.mark.parametrize("recorder", [BtlogRecorder, SqliteRecorder])
def test_a_log_without_a_path_or_that_cannot_be_written_is_one_error(station, recorder, tmp_path):
    with pytest.raises(BtManipError, match=rf"--record FILE\{recorder.suffix}"):
        recorder(None)
    log = recorder(tmp_path / "missing" / "log")
    with pytest.raises(RecordingError, match="log '.*log' cannot be written"):
        run_of(station, Tree(Sleep(msec=20))).execute([log])


def test_a_full_disk_is_one_error_and_a_database_does_not_replace_a_pipe(station, tmp_path):
    with pytest.raises(RecordingError, match="cannot be written: No space left on device"):
        run_of(station, Tree(Sleep(msec=20))).execute([BtlogRecorder(Path("/dev/full"))])
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(RecordingError, match="it is no regular file"):
        run_of(station, Tree(Sleep(msec=20))).execute([SqliteRecorder(pipe)])
    assert pipe.is_fifo()


def test_logs_of_a_recording_are_those_of_the_run(bt_manip, station, tmp_path):
    logs = BtlogRecorder(tmp_path / "live.btlog"), SqliteRecorder(tmp_path / "live.db3")
    run = run_of(station, Tree(coming_and_going()))
    run.execute([*logs, McapRecorder(tmp_path / "run.mcap")])
    for name in ("run.btlog", "run.db3"):
        assert bt_manip("export", tmp_path / "run.mcap", "-o", tmp_path / name).code == 0
    live, exported = ((tmp_path / f"{name}.btlog").read_bytes() for name in ("live", "run"))
    start = 23 + int.from_bytes(live[19:23], "little")  # of the wall time of the start
    assert exported[:start] == live[:start] and exported[start + 8 :] == live[start + 8 :]
    assert len(live) > start + 8 + 10 * 9
    rows = []
    for path in (tmp_path / "live.db3", tmp_path / "run.db3"):
        changes = read_database(
            path, "SELECT timestamp, node_uid, duration, state FROM Transitions ORDER BY timestamp"
        )
        nodes = read_database(path, "SELECT * FROM Nodes")
        xml = read_database(path, "SELECT xml_tree FROM Definitions")
        rows.append(([(t - changes[0][0], *rest) for t, *rest in changes], nodes, xml))
    assert rows[0] == rows[1]
