"""bt-manip replay: a recording on a page; bad input is one line."""

import re
import signal

import click

from bt_manip.cli import run_app


def test_bad_input_is_one_line(bt_manip, recording, tmp_path):
    (tmp_path / "text.mcap").write_text("no recording")
    (tmp_path / "cut.mcap").write_bytes(recording.read_bytes()[:500])
    for name, message in (
        ("missing.mcap", "cannot read .*missing.mcap': No such file or directory"),
        ("text.mcap", "text.mcap is no MCAP file"),
        ("cut.mcap", "cut.mcap has no complete chunk: it has no scene"),
    ):
        code, out, err = bt_manip("replay", tmp_path / name)
        assert (code, out) == (2, "")
        assert re.fullmatch(f"Error: .*{message}\n", err)
    assert bt_manip("replay", recording, "--speed", "0").code == 2
    late = bt_manip("replay", recording, "--from", "9")
    assert (late.code, late.err) == (2, f"Error: {recording} ends at 0.060 s, before 9 s\n")


def test_ctrl_c_ends_it_in_order_as_soon_as_the_address_is_printed(
    recording, interrupt, monkeypatch, capfd
):
    monkeypatch.setattr(click, "echo", lambda line: signal.raise_signal(signal.SIGINT))
    assert run_app(interrupt, ["replay", str(recording), "--port", "0"]) == 0
    assert capfd.readouterr() == ("", "")


def test_ctrl_c_is_how_it_ends(start, recording):
    program = start("replay", recording, "--port", "0")
    assert program.url and program.interrupt() == 0
