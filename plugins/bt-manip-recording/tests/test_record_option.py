"""bt-manip run --record: recordings from the command line."""

import pytest

from bt_manip_recording import Recording, read_trace


def test_a_bare_file_name_chooses_the_recorder_and_the_last_line_opens_the_recording(
    bt_manip, trees, tmp_path
):
    recording, trace = tmp_path / "a run.mcap", tmp_path / "run.npz"
    options = "--record", str(recording), "--record", str(trace)
    code, out, err = bt_manip("run", f"{trees}:quick", *options)
    assert (code, err) == (0, "")
    hint = (
        f"To watch the recording: bt-manip replay '{recording}', or bt-manip report '{recording}'"
    )
    assert hint in " ".join(out.split())
    assert Recording(recording).complete and len(read_trace(trace)["t"]) > 20
    assert bt_manip("run", f"{trees}:quick", *options, "--quiet") == (0, "", "")


@pytest.mark.parametrize(("tree", "code"), [("failing", 1), ("loud", 3)])
def test_a_run_that_fails_or_ends_with_a_fault_leaves_a_complete_recording(
    bt_manip, trees, tmp_path, tree, code
):
    path = tmp_path / "run.mcap"
    done = bt_manip("run", f"{trees}:{tree}", "--record", f"mcap={path}")
    assert done.code == code and "To watch the recording:" in done.out
    recording = Recording(path)
    assert recording.complete and recording.end >= 0.02


@pytest.mark.parametrize(
    ("record", "message"),
    [
        ("run.mcap camera=panda/wrist", "recorder 'mcap' has no parameter 'camera'; did you mean"),
        ("mcap", "a recording needs a file"),
    ],
)
def test_bad_options_of_a_recorder_are_bad_input(bt_manip, trees, tmp_path, record, message):
    text = record.replace("run.", f"{tmp_path}/run.")
    code, _, err = bt_manip("run", f"{trees}:quick", "--record", text)
    assert code == 2 and message in err
    assert not [path for path in tmp_path.iterdir() if path.stem == "run"]


def test_the_options_of_a_recorder_are_listed_with_their_defaults(bt_manip):
    out = bt_manip("list", "recorders", "mcap").out
    assert out.startswith("mcap (") and "  cameras (" in out
