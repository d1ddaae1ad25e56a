"""bt-manip export: a recording becomes other files."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from bt_manip.bt import Sleep
from bt_manip_recording import McapRecorder, Recording, read_trace


@pytest.fixture(scope="module")
def recorded(make_run, tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "run.mcap"
    make_run(Sleep("rest", msec=20)).execute([McapRecorder(path)])
    return path


@pytest.fixture
def recording(recorded, tmp_path):
    return shutil.copy(recorded, tmp_path / "run.mcap")


def test_each_format_has_its_suffix(bt_manip, recording):
    for form in ("csv", "parquet"):
        code, out, err = bt_manip("export", recording, "--to", form)
        file = recording.with_suffix(f".{form}")
        assert (code, err) == (0, "") and out.startswith(f"{file}: ") and file.stat().st_size > 100


def test_an_exported_trace_is_the_trace_of_the_run(bt_manip, task, tmp_path):
    run, trace = tmp_path / "run.mcap", tmp_path / "trace.npz"
    tree = task('<MoveToConfiguration configuration="0.1;-0.7;0.1;-2.3;0.0;1.6;0.8"/>')
    assert bt_manip("run", tree, "--record", run, "--trace", trace).code == 0
    assert bt_manip("export", run, "--to", "npz").code == 0
    expected, found = read_trace(trace), read_trace(run.with_suffix(".npz"))
    assert list(found) == list(expected)
    for name in expected:
        if name == "t":  # a recording counts whole nanoseconds
            np.testing.assert_allclose(found["t"], expected["t"], rtol=0.0, atol=1e-9)
        else:
            np.testing.assert_array_equal(found[name], expected[name])


README = Path(__file__).resolve().parents[1] / "README.md"


def test_register_export_formats_converts_recordings(bt_manip, recording, tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    (code,) = (block for block in blocks if "register_export_formats" in block)
    (tmp_path / "of_register_export_formats.py").write_text(code)
    assert bt_manip("export", recording, "--to", "times", "--plugins-dir", tmp_path).code == 0
    times = recording.with_suffix(".times").read_text().split()
    assert times[0] == "0.000" and float(times[-1]) == 0.02


def test_the_name_of_the_file_chooses_the_format(bt_manip, recording, tmp_path):
    assert bt_manip("export", recording, "-o", tmp_path / "table.csv").code == 0
    assert (tmp_path / "table.csv").read_text().startswith('"t","panda/joint1/q"')


def test_a_complete_recording_is_a_file_of_its_own(bt_manip, recording):
    recording.write_bytes(recording.read_bytes()[:-100])
    assert bt_manip("export", recording, "--to", "mcap").code == 0
    assert not Recording(recording).complete
    assert Recording(recording.with_suffix(".complete.mcap")).complete


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "--to or the suffix of --out is one of csv, parquet, npz, mcap"),
        (("-o", "run.txt"), "unknown export format 'txt'"),
        (("--to", "csv", "--fps", "3"), "--fps is an option of mp4 and gif"),
        (("--to", "csv", "-o", "missing/run.csv"), "there is no folder 'missing'"),
    ],
)
def test_bad_input_is_said(bt_manip, recording, arguments, message):
    code, _, err = bt_manip("export", recording, *arguments)
    assert code == 2 and message in " ".join(err.split())


def test_a_format_of_a_missing_package_names_it(bt_manip, recording, monkeypatch):
    monkeypatch.setenv("BT_MANIP_BLOCK", "groot,view")
    for form, package in (("btlog", "bt-manip-groot"), ("gif", "bt-manip-view")):
        code, _, err = bt_manip("export", recording, "--to", form)
        assert code == 2 and f"needs the package {package}: pip install" in " ".join(err.split())


@pytest.mark.parametrize("form", ["csv", "npz"])
def test_the_recording_is_not_replaced(bt_manip, recording, form):
    before = recording.read_bytes()
    code, _, err = bt_manip("export", recording, "--to", form, "-o", recording)
    assert code == 2 and "it would replace the recording" in err
    assert recording.read_bytes() == before


@pytest.mark.parametrize("form", ["csv", "parquet", "mcap"])
def test_a_full_disk_is_said(bt_manip, recording, form):
    code, _, err = bt_manip("export", recording, "--to", form, "-o", "/dev/full")
    assert code == 2 and "'/dev/full' cannot be written: " in err and err.count("\n") == 1


def test_what_is_no_recording_is_said(bt_manip, tmp_path):
    assert "No such file" in bt_manip("export", tmp_path / "no.mcap", "--to", "csv").err
    (tmp_path / "a.mcap").write_text("a")
    code, _, err = bt_manip("export", tmp_path / "a.mcap", "--to", "csv")
    assert code == 2 and "is no MCAP file" in err
