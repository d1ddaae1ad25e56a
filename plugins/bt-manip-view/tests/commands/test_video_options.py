"""Videos of bt-manip run --record and of bt-manip export, and their options."""

import os
import subprocess
import sys

import av


def test_words_after_the_file_are_options_of_the_recorder(opengl, bt_manip, trees, tmp_path):
    path = tmp_path / "a run.mp4"
    options = "camera=panda/wrist size=64x48 fps=100"
    code, _, err = bt_manip("run", f"{trees}:quick", "--record", f"{path} {options}")
    assert (code, err) == (0, "")
    with av.open(path) as video:
        assert len(list(video.decode(video=0))) >= 3
        assert video.streams.video[0].width == 64


def test_without_a_choice_of_opengl_a_video_is_rendered_offscreen(opengl, trees, tmp_path):
    path = tmp_path / "run.mp4"
    unset = {k: v for k, v in os.environ.items() if k not in ("MUJOCO_GL", "DISPLAY")}
    arguments = ["run", f"{trees}:quick", "--record", f"{path} size=64x48"]
    done = subprocess.run(
        [sys.executable, "-m", "bt_manip", *arguments], env=unset, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert path.stat().st_size > 1000


def test_a_video_has_the_options_of_its_recorder(opengl, bt_manip, recording, tmp_path):
    options = ("--size", "64x48", "--fps", "10", "--camera", "panda/wrist", "--overlay")
    path = tmp_path / "run.mp4"
    assert bt_manip("export", recording, "--to", "mp4", "-o", path, *options).code == 0
    assert path.stat().st_size > 1000


def test_a_camera_that_is_not_there_is_bad_input(bt_manip, trees, recording, tmp_path):
    path = tmp_path / "run.mp4"
    for command in (
        ("run", f"{trees}:quick", "--record", f"{path} camera=overveiw"),
        ("export", recording, "--to", "mp4", "-o", path, "--camera", "overveiw"),
    ):
        code, _, err = bt_manip(*command)
        assert code == 2
        assert "no camera 'overveiw'; did you mean 'overview'?" in " ".join(err.split())
        assert not path.exists()
