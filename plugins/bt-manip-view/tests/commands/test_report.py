"""bt-manip report: one HTML file of a recording."""

import socket

import pytest


def test_a_report_is_made_on_loopback_beside_the_recording_or_in_the_given_file(
    bt_manip, trees, tmp_path, monkeypatch
):
    hosts = set()

    def noting_hosts(call):
        return lambda used, address: (hosts.add(address[0]), call(used, address))[1]

    for name in ("bind", "connect"):
        monkeypatch.setattr(socket.socket, name, noting_hosts(getattr(socket.socket, name)))
    path, other = tmp_path / "run.mcap", tmp_path / "other.html"
    assert bt_manip("run", f"{trees}:failing", "--record", path).code == 1
    code, out, err = bt_manip("report", path)
    assert (code, err) == (0, "")
    assert out.startswith(f"Page: {tmp_path / 'run.html'} (")
    beside = (tmp_path / "run.html").read_text()
    assert "no object" in beside  # the reason of the failed cycle
    assert "This recording is incomplete" not in beside
    path.write_bytes(path.read_bytes()[:-100])
    code, out, err = bt_manip("report", path, "-o", other)
    assert (code, err) == (0, "") and "The recording ended without an end, at " in out
    assert "This recording is incomplete:" in other.read_text()
    assert hosts == {"127.0.0.1"}


@pytest.mark.parametrize("name", ["run.json", "run.jsonl"])
def test_the_cycles_of_a_report_are_printed(bt_manip, trees, tmp_path, name):
    path = tmp_path / name
    assert bt_manip("run", f"{trees}:failing", "--report", path).code == 1
    code, out, err = bt_manip("report", path)
    assert (code, err) == (0, "") and list(tmp_path.glob("*.html")) == []
    assert "FAILURE" in out and "cycle 1: look" in out and "0 of 1 cycles succeeded" in out
    text = path.read_text()
    if name == "run.json":
        path.write_text(text.replace('"status": "FAILURE"', '"status": "RUNNING"', 1))
    else:
        path.write_text("".join(text.splitlines(keepends=True)[:-1]))
    code, out, _ = bt_manip("report", path)
    assert code == 0 and "the run ended without an end: its process was killed or has left" in (
        " ".join(out.split())
    )


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("text.json", b"[1]", "is not a report"),
        ("missing.jsonl", None, "cannot be read"),
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
