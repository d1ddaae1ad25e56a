"""A file is there whole or not at all."""

import os
import stat

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.record.files import (
    FileInUseError,
    check_exists,
    check_writable,
    open_output,
    whole_file,
)


def test_a_file_appears_only_when_it_is_whole(tmp_path):
    path, other = tmp_path / "report.json", tmp_path / "other"
    check_writable(path, "report")
    assert list(tmp_path.iterdir()) == []
    with whole_file(path) as file:
        file.write(b"all of it")
        assert not path.exists()
    assert path.read_bytes() == b"all of it"
    assert list(tmp_path.iterdir()) == [path]
    other.touch()  # the file has the permissions of any other
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE(other.stat().st_mode)
    link = tmp_path / "link.json"
    link.symlink_to(path)
    with whole_file(link) as file:
        file.write(b"x")
    assert link.is_symlink() and path.read_bytes() == b"x"


@pytest.mark.parametrize(
    ("place", "reason"),
    [
        ("missing/report.json", "there is no folder"),
        ("folder", "it is a folder"),
        ("file/report.json", "is not a folder"),
    ],
)
def test_what_cannot_be_written_is_said_beforehand(tmp_path, place, reason):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    with pytest.raises(BtManipError, match=f"report '.*' cannot be written: .*{reason}"):
        check_writable(tmp_path / place, "report")


def test_a_file_that_another_process_writes_is_neither_opened_nor_changed(tmp_path):
    path = tmp_path / "run.mcap"
    first = open_output(path)
    first.write(b"of the first")
    with pytest.raises(FileInUseError, match=r"run.mcap' cannot be written: it is being"):
        open_output(path)
    with pytest.raises(BtManipError, match="recording '.*' cannot be written: it is being"):
        check_writable(path, "recording")
    assert path.read_bytes() == b"of the first"
    first.close()
    check_writable(path, "recording")
    open_output(path).close()
    assert path.read_bytes() == b""
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_in_the_place_of_a_deleted_one_can_be_opened(tmp_path):
    path = tmp_path / "run.mcap"
    with open_output(path) as first:
        path.unlink()
        with open_output(path) as second:
            check_exists(second)
            with pytest.raises(FileNotFoundError, match="it was deleted"):
                check_exists(first)


def test_what_is_no_regular_file_is_written_directly_and_never_locked(tmp_path):
    pipe = tmp_path / "pipe"  # as /dev/null, which a failure of this test would replace
    os.mkfifo(pipe)
    end = os.open(pipe, os.O_RDWR | os.O_NONBLOCK)
    with whole_file(pipe) as file:
        file.write(b"x")
    assert os.read(end, 10) == b"x" and stat.S_ISFIFO(pipe.stat().st_mode)
    with open_output(pipe), open_output(pipe):
        check_writable(pipe, "recording")
    os.close(end)


def test_what_stood_there_stays_when_writing_fails(tmp_path):
    path = tmp_path / "report.json"
    path.write_bytes(b"yesterday's")
    with pytest.raises(RuntimeError), whole_file(path) as file:
        file.write(b"half of it")
        raise RuntimeError
    assert path.read_bytes() == b"yesterday's"
    assert list(tmp_path.iterdir()) == [path]
