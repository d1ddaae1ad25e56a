"""Outputs that two processes write, or that are deleted during a run."""

import fcntl

import pytest

from bt_manip.cli.app import run_app
from bt_manip.record import files

PLUGIN = """
import signal
from pathlib import Path
from bt_manip import hookimpl

@hookimpl
def before_tick():
    Path({path!r}).unlink(missing_ok=True)
    if {code} == 130:
        signal.raise_signal(signal.SIGINT)
"""


@pytest.fixture
def option(opengl, tmp_path):
    """Return the options that write a file of this name."""

    def option(name):
        path = tmp_path / name
        options = {".json": "--report", ".jsonl": "--report", ".npz": "--trace"}
        size = " size=64x48" if path.suffix == ".mp4" else ""
        return path, options.get(path.suffix, "--record"), f"{path}{size}"

    return option


@pytest.mark.parametrize("name", ["run.json", "run.jsonl", "run.npz", "run.mcap", "run.mp4"])
def test_a_file_that_another_process_writes_is_bad_input(
    bt_manip, trees, option, monkeypatch, name
):
    """The other process opens its file after this one has checked it, but for one format."""
    path, *options = option(name)
    if name != "run.jsonl":
        monkeypatch.setattr(files, "is_locked", lambda path: False)
    with path.open("wb") as other:
        other.write(b"of the other")
        other.flush()
        fcntl.flock(other, fcntl.LOCK_EX)
        code, _, err = bt_manip("run", f"{trees}:quick", *options)
        assert code == 2
        assert path.name in err and "it is being written" in " ".join(err.split())
        assert path.read_bytes() == b"of the other"


@pytest.mark.parametrize("code", [3, 130])
@pytest.mark.parametrize("name", ["run.npz", "run.mcap", "run.mp4"])
def test_a_file_that_is_deleted_during_the_run_is_told(
    interrupt, trees, option, tmp_path, capfd, name, code
):
    """After Ctrl-C, too, whose exit code is 130."""
    path, *options = option(name)
    plugins = tmp_path / "plugins"
    plugins.mkdir()
    (plugins / "deletes.py").write_text(PLUGIN.format(path=str(path), code=code))
    arguments = ["run", f"{trees}:quick", *options, "--plugins-dir", str(plugins)]
    assert run_app(interrupt, arguments) == code
    err = capfd.readouterr().err
    assert path.name in err and "it was deleted" in " ".join(err.split())
