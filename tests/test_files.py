"""Files that a user names are read up to a limit, or refused at once with the reason."""

import errno
import os
import time

import pytest

from bt_manip.files import read_bytes, read_text, replace_text
from bt_manip.toml import MAX_TOML_NESTING, parse_toml


def test_a_regular_file_is_read(tmp_path):
    (tmp_path / "a").write_text("é")
    assert read_text(tmp_path / "a") == "é"
    assert read_bytes(str(tmp_path / "a"), limit=2) == "é".encode()


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("/dev/zero", "not a regular file"),
        ("pipe", "not a regular file"),
        (".", "a folder"),
        ("missing", "No such file"),
        ("a\0b", "not the path of a file"),
    ],
    ids=["device", "pipe", "folder", "missing", "nul"],
)
def test_anything_else_is_refused_at_once(tmp_path, name, reason):
    os.mkfifo(tmp_path / "pipe")
    start = time.monotonic()
    with pytest.raises(OSError) as raised:
        read_bytes(tmp_path / name)
    assert reason in str(raised.value.strerror)
    assert time.monotonic() - start < 1.0  # a device is endless, a pipe waits for its writer


def test_a_file_beyond_the_limit_is_refused(tmp_path):
    (tmp_path / "a").write_bytes(bytes(2**20 + 1))
    with pytest.raises(OSError, match="larger than 1 MB"):
        read_bytes(tmp_path / "a", limit=2**20)


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 100_000 + "]" * 100_000,
        "a = " + "{a = " * 100_000 + "1" + "}" * 100_000,
        "a" + ".a" * 100_000 + " = 1",
        "[" + "a." * 100_000 + "a]",
        'a = ["]", ' + "[" * 100_000,
    ],
    ids=["lists", "tables", "key", "header", "brackets in strings"],
)
def test_deeply_nested_toml_is_refused_at_once(text):
    start = time.process_time()
    with pytest.raises(ValueError, match=f"nested deeper than {MAX_TOML_NESTING} levels"):
        parse_toml(text)
    assert time.process_time() - start < 5.0  # without the check, minutes or a crash


def test_brackets_in_strings_and_comments_do_not_nest():
    many = "[" * 100
    for text in (f'"{many}"', f"'{many}'", f'"""\n{many}"""', f"'''{many}'''", f"1 # {many}"):
        assert parse_toml(f"a = {text}")
    assert parse_toml('a = "\\"' + many + '"')


@pytest.mark.parametrize(
    "text", ["x=" + "9" * 400_000, 'x="' + '\\"' * 200_000, '"""\n\\' * 80_000, "a " * 200_000]
)
def test_a_toml_text_is_read_in_a_time_that_grows_with_its_length_only(text):
    start = time.process_time()
    with pytest.raises(ValueError, match=r"digits|string|'='|character"):
        parse_toml(text)
    assert time.process_time() - start < 2.0  # a quadratic search takes minutes


def test_a_file_that_cannot_be_written_whole_stays_as_it_was(tmp_path, monkeypatch):
    file = tmp_path / "tree.xml"
    replace_text(file, "by hand")
    file.chmod(0o640)

    def full(descriptor):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        replace_text(file, "formatted")
    assert (file.read_text(), list(tmp_path.iterdir())) == ("by hand", [file])
    monkeypatch.undo()
    replace_text(file, "formatted")
    assert (file.read_text(), file.stat().st_mode & 0o777) == ("formatted", 0o640)
