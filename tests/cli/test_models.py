"""``bt-manip models``, against a server of our own."""

import importlib.util
import sys
from pathlib import Path

import pytest

_PLACE = Path(__file__).resolve().parent.parent / "models" / "conftest.py"
_SPEC = importlib.util.spec_from_file_location("fuel_of_the_tests", _PLACE)
assert _SPEC is not None and _SPEC.loader is not None
fuel = importlib.util.module_from_spec(_SPEC)
sys.modules[_SPEC.name] = fuel
_SPEC.loader.exec_module(fuel)
server = fuel.server  # the fixture


@pytest.fixture(autouse=True)
def menagerie_elsewhere(monkeypatch, tmp_path):
    monkeypatch.setenv("MENAGERIE_CACHE_DIR", str(tmp_path / "menagerie"))
    monkeypatch.delenv("MENAGERIE_ROOT", raising=False)


def test_a_model_is_fetched_listed_shown_and_deleted(bt_manip, server, tmp_path):
    sdf = fuel.BALL.replace("</link>", "<sensor name='s'/></link>")
    server.add("someone", "ball", fuel.model_zip(sdf), version=3)
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


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("path", "bundled:cub"), "did you mean 'cube'"),
        (("fetch", "fuel:someone/nothing"), "no such model"),
        (("show", "nowhere.sdf"), "there is no such file"),
        (("clear", "bundled:cube"), "only models of fuel: and menagerie: are downloaded"),
        (("clear", "menagerie:panda"), "no model 'panda'"),
        (("clear",), "or --all"),
        (("clear", "--all", "fuel:a/b"), "or --all"),
        (("list", "nowhere"), "nowhere"),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(bt_manip, server, arguments, words):
    code, out, err = bt_manip("models", *arguments)
    assert code == 2
    assert out == ""
    assert words in err and "Traceback" not in err


def test_the_reference_task_is_one_command(bt_manip, server):
    cube = fuel.bundled_sdf("cube", static=False, raised=0.025)
    server.add("openrobotics", "wood cube 5cm", fuel.model_zip(cube))
    server.add("OpenRobotics", "Table", fuel.model_zip(fuel.bundled_sdf("table", static=True)))
    basket = fuel.bundled_sdf("basket", static=False)
    server.add("GoogleResearch", "Basket", fuel.model_zip(basket))
    code, out, err = bt_manip(
        "run", "pick_place", "--set", "cube=fuel:openrobotics/wood cube 5cm",
        "--set", "table=fuel:OpenRobotics/Table", "--set", "basket=fuel:GoogleResearch/Basket",
    )  # fmt: skip
    assert (code, err) == (0, "")


def test_a_run_with_a_model_that_is_not_there_does_not_begin(bt_manip, server):
    code, out, err = bt_manip("run", "pick_place", "--set", "table=fuel:nobody/Table")
    assert code == 2
    assert "no such model" in err and out == ""
