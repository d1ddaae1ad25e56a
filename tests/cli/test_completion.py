"""The shell completes registered names, and the keys of the tree that stands on the line."""

import re
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

from bt_manip import plugins
from bt_manip.cli.app import app
from tests.support.program import run_python


def completed(*words: object) -> list[str]:
    """Give what TAB offers behind the last of these words."""
    *before, last = map(str, words)
    shell = ShellComplete(app, {}, "bt-manip", "_BT_MANIP_COMPLETE")
    return [item.value for item in shell.get_completions(before, last)]


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (("ru",), "run"),
        (("run", "pick_"), "pick_place"),
        (("run", "pick_place", "--robot", ""), "panda"),
        (("run", "pick_place", "--controller", "comp"), "computed_torque"),
        (("run", "pick_place", "--scene", "var"), "varied_pick"),
        (("run", "pick_place", "--set", "fo"), "force="),
        (("tree", "show", "pick"), "pick_place"),
        (("scene", "show", "tab"), "table_and_basket"),
        (("list", "beh"), "behaviours"),
        (("list", "Gra"), "Grasp"),
        (("list", "behaviours", "Seq"), "Sequence"),
        (("models", "list", "men"), "menagerie"),
        (("run", "--pl"), "--plugins-dir"),
    ],
)
def test_names_are_completed(words, offered):
    found = completed(*words)
    assert offered in found
    assert all(name.startswith(words[-1]) for name in found)


def test_keys_of_a_python_tree_are_completed_without_running_its_file(trees):
    trees.write_text(trees.read_text() + "\nraise RuntimeError('it was imported')\n")
    assert completed("run", f"{trees}:quick", "--set", "") == ["name="]
    assert completed("run", f"{trees}:endless", "--set", "") == []


def test_of_an_unknown_tree_no_keys_are_offered():
    for tree in ("pick_plce", "none.py:tree", "no_module:tree"):
        assert completed("run", tree, "--set", "") == []


def test_the_command_of_the_guide_gives_the_shell_its_script(tmp_path):
    page = (Path(__file__).resolve().parents[2] / "docs" / "start.md").read_text()
    (variable, value) = re.findall(r"\$\((\w+)=(\w+) bt-manip\)", page)[0]
    script = run_python("-m", "bt_manip", cwd=tmp_path, **{variable: value})
    assert "complete" in script and "bt-manip" in script


def test_where_no_name_fits_the_shell_completes_files(trees):
    shell = ShellComplete(app, {}, "bt-manip", "_BT_MANIP_COMPLETE")
    (item,) = shell.get_completions(["run"], str(trees)[:-3])
    assert item.type == "file"


# The second TAB


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """Give the folder of the cache, which is empty."""
    monkeypatch.setenv("BT_MANIP_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / "completion"


@pytest.fixture
def loads(monkeypatch):
    counted = []
    load = plugins.load_plugins
    monkeypatch.setattr(
        plugins, "load_plugins", lambda **options: counted.append(options) or load(**options)
    )
    return counted


@pytest.mark.parametrize(
    "words", [("run", "pick_"), ("run", "pick_place", "--set", ""), ("list", "Gra")]
)
def test_the_second_tab_loads_no_plugin(cache, loads, words):
    first = completed(*words)
    assert first and loads
    loads.clear()
    assert completed(*words) == first
    assert not loads


def test_an_edited_plugin_or_tree_is_asked_again(cache, loads, trees, tmp_path):
    plugin = tmp_path / "plugins" / "trees_of_mine.py"
    plugin.parent.mkdir()
    plugin.write_text("from bt_manip import hookimpl\n")
    for _ in range(2):
        assert "pick_place" in completed("run", "--plugins-dir", plugin.parent, "")
    assert len(loads) == 1
    plugin.write_text("from bt_manip import hookimpl  # edited\n")
    assert "pick_place" in completed("run", "--plugins-dir", plugin.parent, "")
    assert len(loads) == 2
    assert completed("run", f"{trees}:quick", "--set", "") == ["name="]
    trees.write_text(trees.read_text().replace("name", "another"))
    assert completed("run", f"{trees}:quick", "--set", "") == ["another="]


@pytest.mark.parametrize("text", ["", "{}", '{"stamp": 1, "answers": 2}'])
def test_a_damaged_cache_is_made_anew(cache, loads, text):
    first = completed("run", "pick_")
    for file in cache.iterdir():
        file.write_text(text)
    assert completed("run", "pick_") == first
    loads.clear()
    assert completed("run", "pick_") == first
    assert not loads
