"""bt-manip export: a recording becomes other files."""

import importlib.util

import numpy as np
import pytest

from bt_manip.cli.export import FORMATS, ExportFormat
from bt_manip.record import Recording, read_trace


@pytest.fixture
def recording(bt_manip, trees, tmp_path):
    path = tmp_path / "run.mcap"
    assert bt_manip("run", f"{trees}:quick", "--record", path).code == 0
    return path


def test_each_format_has_its_suffix(bt_manip, recording):
    for form in ("csv", "parquet"):
        code, out, err = bt_manip("export", recording, "--to", form)
        file = recording.with_suffix(f".{form}")
        assert (code, err) == (0, "") and out.startswith(f"{file}: ") and file.stat().st_size > 100


def write_times(recording, path):
    path.write_text(f"{recording.control_steps()['t'][-1]:.3f}")


def test_a_new_format_is_one_line(bt_manip, recording, monkeypatch):
    monkeypatch.setitem(FORMATS, "times", ExportFormat(f"{__name__}:write_times"))
    assert bt_manip("export", recording, "--to", "times").code == 0
    end = Recording(recording).control_steps()["t"][-1]
    assert recording.with_suffix(".times").read_text() == f"{end:.3f}"


@pytest.mark.parametrize("tree", ["pick_place", pytest.param("two_arms", marks=pytest.mark.soak)])
def test_an_exported_trace_is_the_trace_of_the_run(bt_manip, tree, tmp_path):
    run, trace = tmp_path / "run.mcap", tmp_path / "trace.npz"
    assert bt_manip("run", tree, "--record", run, "--trace", trace).code == 0
    assert bt_manip("export", run, "--to", "npz").code == 0
    expected, found = read_trace(trace), read_trace(run.with_suffix(".npz"))
    assert list(found) == list(expected)
    for name in expected:
        if name == "t":  # a recording counts whole nanoseconds
            np.testing.assert_allclose(found["t"], expected["t"], rtol=0.0, atol=1e-9)
        else:
            np.testing.assert_array_equal(found[name], expected[name])


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
        ((), "--to or the suffix of --out is one of csv, parquet, npz, mcap, "),
        (("-o", "run.txt"), "--to or the suffix of --out is one of csv"),
        (("--to", "csv", "--fps", "3"), "--fps is an option of mp4 and gif"),
        (("--to", "csv", "-o", "missing/run.csv"), "there is no folder 'missing'"),
    ],
)
def test_bad_input_is_said(bt_manip, recording, arguments, message):
    code, _, err = bt_manip("export", recording, *arguments)
    assert code == 2 and message in " ".join(err.split())


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


def test_without_the_package_the_message_names_the_extra(bt_manip, tmp_path, monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "pyarrow" else find(name)
    )
    code, _, err = bt_manip("export", tmp_path / "a.mcap", "--to", "csv")
    assert code == 2 and "export needs pyarrow: pip install 'bt-manip[record]'" in err
