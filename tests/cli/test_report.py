"""bt-manip report: one HTML file of a recording."""

import importlib.util

import pytest

pytest.importorskip("viser", reason="the extra [view] is not installed")


def test_the_report_is_written_beside_the_recording_or_to_the_given_file(bt_manip, trees, tmp_path):
    assert bt_manip("run", f"{trees}:failing", "--record", tmp_path / "run.mcap").code == 1
    code, out, err = bt_manip("report", tmp_path / "run.mcap")
    assert (code, err) == (0, "")
    assert out.startswith(f"Page: {tmp_path / 'run.html'} (")
    beside = (tmp_path / "run.html").read_bytes()
    assert b"no object" in beside  # the reason of the failed cycle
    assert bt_manip("report", tmp_path / "run.mcap", "-o", tmp_path / "other.html").code == 0
    assert len((tmp_path / "other.html").read_bytes()) == pytest.approx(len(beside), rel=0.01)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.mcap", None, "cannot read"),
        ("text.mcap", b"no recording", "is no MCAP file"),
        ("empty.mcap", b"\x89MCAP0\r\n", "is not the recording of a run"),
    ],
)
def test_bad_input_is_one_line(bt_manip, tmp_path, name, content, message):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    code, out, err = bt_manip("report", path)
    assert (code, out) == (2, "")
    assert err.startswith("Error: ") and err.count("\n") == 1 and message in err
    assert not path.with_suffix(".html").exists()


def test_a_file_that_cannot_be_written_is_refused(bt_manip, tmp_path):
    path = tmp_path / "run.mcap"
    path.write_bytes(b"\x89MCAP0\r\n")
    assert "would replace the recording" in bt_manip("report", path, "-o", path).err
    done = bt_manip("report", path, "-o", tmp_path / "no" / "report.html")
    assert (done.code, done.err.count("\n")) == (2, 1)
    assert path.read_bytes() == b"\x89MCAP0\r\n"


@pytest.mark.parametrize(("package", "extra"), [("mcap", "record"), ("bokeh", "view")])
def test_a_missing_package_is_named_with_its_extra(bt_manip, monkeypatch, package, extra):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *rest: None if name == package else find(name)
    )
    code, _, err = bt_manip("report", "run.mcap")
    assert (code, err) == (2, f"Error: report needs {package}: pip install 'bt-manip[{extra}]'\n")
