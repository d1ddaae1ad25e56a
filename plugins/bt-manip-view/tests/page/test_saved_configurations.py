"""Configurations that the page saves are read back, and nothing else changes."""

import pytest

from bt_manip.robots import RobotError, load_configurations
from bt_manip_view.page.saved_configurations import save_configuration


def test_saved_configurations_are_read_back_and_those_that_need_quotes_stay(tmp_path):
    path = tmp_path / "configurations.toml"
    save_configuration(path, "above_bin", [1.0, 2.0])
    known = {"above bin": (1.0,), "a.b": (2.0,), 'say "ä"\n': (3.0,)}
    keys = ('"above bin"', '"a.b"', '"say \\"ä\\"\\n"')
    with path.open("a", encoding="utf-8") as file:
        file.writelines(f"{key} = {list(q)}\n" for key, q in zip(keys, known.values(), strict=True))
    save_configuration(path, "ready", [0.5, -1.0])
    save_configuration(path, "ready", [0.25, 1e-7])
    assert load_configurations(path) == known | {"above_bin": (1.0, 2.0), "ready": (0.25, 0.0)}


@pytest.mark.parametrize("name", ["", "above bin", "a.b", "home", "a]"])
def test_an_invalid_name_is_not_saved(tmp_path, name):
    path = tmp_path / "configurations.toml"
    with pytest.raises(RobotError, match="letters, digits, '_' and '-', and not 'home'"):
        save_configuration(path, name, [0.5])
    assert not path.exists()


def test_a_file_with_anything_else_is_not_changed(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("seed = 3\n")
    with pytest.raises(RobotError, match="seed"):
        save_configuration(path, "ready", [0.5])
    assert path.read_text() == "seed = 3\n"
