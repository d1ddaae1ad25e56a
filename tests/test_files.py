"""Files that a user names are read up to a limit, or refused at once with the reason."""

import os
import time

import pytest

from bt_manip.files import read_bytes, read_text
from bt_manip.toml import MAX_TOML_NESTING, parse_toml


@pytest.fixture
def pipe(tmp_path):
    """Give a pipe that nobody writes to."""
    os.mkfifo(tmp_path / "pipe")
    return tmp_path / "pipe"


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
def test_anything_else_is_refused_at_once(tmp_path, pipe, name, reason):
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
