"""``bt-manip models``: models that travel with the package, and those of Menagerie."""

import pytest


@pytest.fixture(autouse=True)
def menagerie_elsewhere(monkeypatch, tmp_path):
    monkeypatch.setenv("MENAGERIE_CACHE_DIR", str(tmp_path / "menagerie"))
    monkeypatch.delenv("MENAGERIE_ROOT", raising=False)


def test_bundled_models_are_listed_found_and_shown(bt_manip):
    assert "bundled:cube" in bt_manip("models", "list").out.splitlines()
    assert "bundled:cube" in bt_manip("models", "list", "bundled").out.splitlines()
    path = bt_manip("models", "path", "bundled:cube").out
    assert path.endswith("cube/cube.xml\n")
    assert path.strip() in bt_manip("models", "fetch", "bundled:cube").out
    shown = bt_manip("models", "show", "bundled:cube").out
    facts = dict(line.split(maxsplit=1) for line in shown.splitlines())
    assert facts["format"] == "mjcf" and facts["category"] == "graspable"


def test_models_of_menagerie_are_listed_and_deleted(bt_manip, tmp_path):
    listed = bt_manip("models", "list", "menagerie").out.splitlines()
    assert "menagerie:franka_emika_panda *" in listed  # not downloaded
    assert bt_manip("models", "clear", "--all", "--yes", "--block", "fuel").out == (
        "nothing to delete\n"
    )
    assert bt_manip("models", "clear", "menagerie:franka_emika_panda").out == "nothing to delete\n"


@pytest.mark.parametrize("command", ["fetch", "show"])
def test_a_broken_plugin_is_one_warning(bt_manip, tmp_path, command):
    (tmp_path / "broken.py").write_text("raise ValueError")
    (tmp_path / "ball.xml").write_text("<mujoco><worldbody><geom size='.1'/></worldbody></mujoco>")
    arguments = "models", command, tmp_path / "ball.xml", "--plugins-dir", tmp_path
    code, _, err = bt_manip(*arguments)
    assert (code, err.count("is left out")) == (0, 1)


@pytest.mark.parametrize(
    "arguments",
    [("path", "fuel:a/b"), ("fetch", "fuel:a/b"), ("clear", "https://x/a/models/b"),
     ("list", "fuel"), ("show", "thing.sdf")],
)  # fmt: skip
def test_models_of_fuel_and_sdf_name_the_package_that_has_them(
    bt_manip, arguments, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "thing.sdf").touch()
    code, out, err = bt_manip("models", *arguments, "--block", "fuel")
    assert (code, out) == (2, "")
    assert err.endswith(
        "needs the package bt-manip-fuel: pip install ./plugins/bt-manip-fuel (in a clone)\n"
    )
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("path", "bundled:cub"), "did you mean 'cube'"),
        (("show", "nowhere.sdf"), "there is no such file"),
        (("clear", "bundled:cube"), "only models of "),
        (("clear", "menagerie:panda"), "no model 'panda'"),
        (("clear",), "or --all"),
        (("clear", "--all", "fuel:a/b"), "or --all"),
        (("list", "nowhere"), "nowhere"),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(bt_manip, arguments, words):
    code, out, err = bt_manip("models", *arguments)
    assert code == 2
    assert out == ""
    assert words in err and "Traceback" not in err
