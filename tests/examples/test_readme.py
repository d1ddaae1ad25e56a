"""The commands, messages and picture of the README are those of the program."""

import importlib.util
import re
import runpy
from pathlib import Path

import av
import numpy as np
import pytest

from bt_manip.viewer import render
from tests.support.program import run_program

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()


def block(language: str, mark: str) -> str:
    """Give the one block of code in a language that has something in it."""
    blocks = re.findall(rf"^```{language}\n(.*?)^```", README, re.DOTALL | re.MULTILINE)
    (found,) = (text for text in blocks if mark in text)
    return found


@pytest.fixture
def tree(tmp_path) -> Path:
    path = tmp_path / "pick.xml"
    path.write_text(block("xml", "BehaviorTree"))
    return path


def test_the_first_tree_runs(tree):
    assert run_program("run", tree, "--quiet") == 0


@pytest.mark.parametrize(
    ("old", "new", "code", "quote"),
    [
        ('force="30"', 'force="300"', 1, "the gripper holds with up to 140 N, not 300 N"),
        ("<Grasp", "<Graps", 2, "no node is named 'Graps'; did you mean 'Grasp'?"),
    ],
)
def test_what_is_wrong_with_it_is_said_as_quoted(tree, old, new, code, quote, capfd):
    assert f"`{quote}`" in README
    assert old in tree.read_text()
    tree.write_text(tree.read_text().replace(old, new))
    assert run_program("run", tree) == code
    assert quote in "".join(capfd.readouterr())


def test_the_first_tree_in_python_runs_by_command_and_as_a_script(tmp_path, capsys):
    script = tmp_path / "pick.py"
    script.write_text(block("python", "station.run(pick)"))
    assert "`bt-manip run pick.py:pick`" in README
    assert run_program("run", f"{script}:pick", "--quiet") == 0
    assert capsys.readouterr().out == ""  # importing it runs nothing
    runpy.run_path(str(script), run_name="__main__")
    assert capsys.readouterr().out == "SUCCESS\n"


def test_its_picture_is_what_the_project_draws(opengl):
    """A driver may differ in a shade and a planner by a step; a view of its own differs by far."""
    path = ROOT / "docs" / "images" / "render.py"
    spec = importlib.util.spec_from_file_location("render_picture", path)
    assert spec is not None and spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    cell = script.pick_place_in_the_middle().cell
    drawn = render(cell).astype(int)
    _, shown = frame_of(path.with_name("pick_place.png"), 0.0)
    differs = np.abs(drawn - shown).max(axis=2) > 40
    assert differs.mean() < 0.02, f"draw it anew: python {path.relative_to(ROOT)}"
    # In the animation the arm does not stop there, and an overlay covers the upper left corner.
    time, frame = frame_of(path.with_name("pick_place.gif"), cell.time)
    drawn = render(cell, width=frame.shape[1], height=frame.shape[0]).astype(int)
    differs = (np.abs(drawn - frame).max(axis=2) > 40)[100:]
    assert abs(time - cell.time) < 0.05 and differs.mean() < 0.1, "render it anew"


def frame_of(path: Path, time: float) -> tuple[float, np.ndarray]:
    """Give the frame of a video or picture that is nearest to a time, and its time."""
    with av.open(path) as video:
        frames = {float(one.time): one.to_ndarray(format="rgb24") for one in video.decode(video=0)}
    nearest = min(frames, key=lambda one: abs(one - time))
    return nearest, frames[nearest].astype(int)
