"""A trace holds every control step."""

import os
from contextlib import closing

import numpy as np
import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.record import RecordingError
from bt_manip.runner import STEP_FIELDS
from bt_manip_recording import Trace, read_trace


def block(first: int, n: int) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Make rows of two joints in which every number tells where it belongs."""
    t = np.arange(first, first + n) / 1000.0
    return t, tuple(100.0 * i + np.column_stack((t, -t)) for i in range(len(STEP_FIELDS)))


def test_a_trace_is_read_while_the_run_goes_on(tmp_path):
    path = tmp_path / "run.npz"
    trace = Trace(path)
    for first in (0, 256):
        trace.append(*block(first, 256))
        t, columns = block(0, first + 256)
        read = read_trace(path)
        assert list(read) == ["t", *STEP_FIELDS]
        np.testing.assert_array_equal(read["t"], t)
        for name, column in zip(STEP_FIELDS, columns, strict=True):
            np.testing.assert_array_equal(read[name], column)
            np.testing.assert_array_equal(np.load(path)[name], column)
    running = read_trace(path)
    trace.close()
    done = read_trace(path)
    assert list(done) == list(running)
    for name in done:
        np.testing.assert_array_equal(done[name], running[name])
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("rest", [1, 100_000])
def test_steps_of_which_a_part_was_written_are_left_out(tmp_path, rest):
    path = tmp_path / "run.npz"
    Trace(path).append(*block(0, 256))
    path.write_bytes(path.read_bytes() + bytes(rest))
    assert len(read_trace(path)["t"]) == 256


def test_a_full_disk_ends_the_trace_and_what_was_written_stays(tmp_path, file_size_limit):
    path = tmp_path / "run.npz"
    trace = Trace(path)
    file_size_limit(100_000)
    for first in range(0, 2560, 256):
        trace.append(*block(first, 256))
    kept = len(read_trace(path)["t"])
    assert 256 < kept < 2560
    lost = f"trace '{path}' cannot be written: File too large; the steps from {kept / 1000:.3f} s"
    with pytest.raises(RecordingError, match=lost):
        trace.close()
    assert len(read_trace(path)["t"]) == kept


def test_a_disk_without_space_for_the_archive_leaves_all_steps(tmp_path, file_size_limit):
    path = tmp_path / "run.npz"
    trace = Trace(path)
    trace.append(*block(0, 1000))
    file_size_limit(path.stat().st_size)
    with pytest.raises(RecordingError, match=f"trace '{path}' cannot be completed: File too large"):
        trace.close()
    assert len(read_trace(path)["t"]) == 1000


@pytest.mark.parametrize("content", [b"", b"PK", b"\x93NUMPY\x01\x00", b"no trace", None])
def test_what_is_no_trace_is_refused(tmp_path, content):
    path = tmp_path / "run.npz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(BtManipError, match=f"'{path}' (is not a trace|cannot be read)"):
        read_trace(path)


def test_a_run_without_a_step_leaves_an_empty_trace(tmp_path):
    Trace(tmp_path / "run.npz").close()
    with np.load(tmp_path / "run.npz") as read:
        assert read["t"].shape == (0,)


def test_the_same_rows_make_the_same_bytes(tmp_path):
    for name in ("a.npz", "b.npz"):
        with closing(Trace(tmp_path / name)) as trace:
            trace.append(*block(0, 10))
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_an_unwritable_trace_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "missing" / "run.npz", tmp_path / "pipe"):
        with pytest.raises(BtManipError, match="trace '.*' cannot be written"):
            Trace(path)
