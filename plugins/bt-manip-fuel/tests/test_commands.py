"""``bt-manip models``, and a run, against a server of our own."""

import json
from pathlib import Path

import pytest

from .fuel_server import BALL, bundled_sdf, model_zip


@pytest.fixture(autouse=True)
def menagerie_elsewhere(monkeypatch, tmp_path):
    monkeypatch.setenv("MENAGERIE_CACHE_DIR", str(tmp_path / "menagerie"))
    monkeypatch.delenv("MENAGERIE_ROOT", raising=False)


def test_a_model_is_fetched_listed_shown_and_deleted(bt_manip, server, tmp_path):
    sdf = BALL.replace("</link>", "<sensor name='s'/></link>")
    server.add("someone", "ball", model_zip(sdf), version=3)
    code, out, err = bt_manip("models", "fetch", "fuel:someone/ball")
    assert (code, err) == (0, "")
    assert out.startswith("fuel:someone/ball/3  ")
    assert bt_manip("models", "list", "fuel").out == "fuel:someone/ball/3\n"
    assert "bundled:cube" in bt_manip("models", "list").out
    path = bt_manip("models", "path", "fuel:someone/ball").out.strip()
    assert Path(path).read_text() == sdf
    code, out, err = bt_manip("models", "show", "fuel:someone/ball")
    facts = dict(line.split(maxsplit=1) for line in out.splitlines())
    assert facts["mass"] == "1 kg" and facts["size"] == "0.040 x 0.040 x 0.040 m"
    assert facts["category"] == "graspable" and facts["format"] == "sdf"
    assert "model.sdf:3: <sensor> of <link> cannot be expressed" in err
    assert "<mujoco" in bt_manip("models", "show", "--mjcf", "fuel:someone/ball").out
    assert "deleted" in bt_manip("models", "clear", "fuel:someone/ball").out
    assert bt_manip("models", "list", "fuel").out == ""
    assert bt_manip("models", "clear", "--all", "--yes").out == "nothing to delete\n"
    assert not Path(path).exists()


def test_a_model_that_is_nowhere_is_one_message_and_exit_code_2(bt_manip, server):
    code, out, err = bt_manip("models", "fetch", "fuel:someone/nothing")
    assert (code, out) == (2, "")
    assert "no such model" in err and "Traceback" not in err


def test_the_reference_task_is_one_command(bt_manip, server, tmp_path):
    cube = bundled_sdf("cube", static=False, raised=0.025)
    server.add("openrobotics", "wood cube 5cm", model_zip(cube))
    server.add("OpenRobotics", "Table", model_zip(bundled_sdf("table", static=True)))
    basket = bundled_sdf("basket", static=False)
    server.add("GoogleResearch", "Basket", model_zip(basket))
    code, out, err = bt_manip(
        "run", "pick_place", "--set", "cube=fuel:openrobotics/wood cube 5cm",
        "--set", "table=fuel:OpenRobotics/Table", "--set", "basket=fuel:GoogleResearch/Basket",
        "--report", tmp_path / "report.json",
    )  # fmt: skip
    assert (code, err) == (0, "")
    (cycle,) = json.loads((tmp_path / "report.json").read_text())["cycles"]
    assert (cycle["status"], cycle["placed"]) == ("SUCCESS", True)
    assert cycle["object"] == "wood_cube_5cm"
    assert cycle["unexpected_contacts"] == []
    assert 0.95 * 50.0 <= cycle["grip_force_n"] <= 1.2 * 50.0


def test_a_run_with_a_model_that_is_not_there_does_not_begin(bt_manip, server):
    code, out, err = bt_manip("run", "pick_place", "--set", "table=fuel:nobody/Table")
    assert code == 2
    assert "no such model" in err and out == ""
