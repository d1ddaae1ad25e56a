"""A trace holds every control step."""

from contextlib import closing

import numpy as np
import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.recording.trace import COLUMNS, Trace


def block(first: int, n: int) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Make rows of two joints in which every number tells where it belongs."""
    t = np.arange(first, first + n) / 1000.0
    return t, tuple(100.0 * i + np.column_stack((t, -t)) for i in range(len(COLUMNS)))


def test_blocks_come_back_in_one_piece(tmp_path):
    with closing(Trace(tmp_path / "run.npz")) as trace:
        trace.append(*block(0, 256))
        trace.append(*block(256, 3))
    t, columns = block(0, 259)
    with np.load(tmp_path / "run.npz") as read:
        assert sorted(read.files) == sorted(("t", *COLUMNS))
        np.testing.assert_array_equal(read["t"], t)
        for name, column in zip(COLUMNS, columns, strict=True):
            np.testing.assert_array_equal(read[name], column)


def test_rows_are_copied(tmp_path):
    t, columns = block(0, 4)
    with closing(Trace(tmp_path / "run.npz")) as trace:
        trace.append(t, columns)
        columns[0][:] = np.nan
    with np.load(tmp_path / "run.npz") as read:
        assert np.isfinite(read["q"]).all()


def test_there_is_no_file_before_the_end(tmp_path):
    with closing(Trace(tmp_path / "run.npz")) as trace:
        trace.append(*block(0, 4))
        assert list(tmp_path.iterdir()) == []


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
    with pytest.raises(BtManipError, match="trace '.*' cannot be written"):
        Trace(tmp_path / "missing" / "run.npz")
