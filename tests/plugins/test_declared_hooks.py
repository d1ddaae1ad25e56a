"""A plugin declares a hook for parts of its own, which other plugins register."""

import sys
from importlib.metadata import EntryPoint

import pytest

from bt_manip import build_station
from bt_manip.exceptions import BtManipError
from bt_manip.plugins import PluginSelection, load_plugins

DECLARES = """
from bt_manip import hookimpl, hookspec
from bt_manip.exceptions import BtManipError

def check(name, lamp):
    if lamp < 0:
        raise BtManipError(f"lamp '{name}' is no brightness")

@hookspec("lamp", check)
def register_lamps(register):
    '''Register lamps.'''

@hookimpl(specname="register_lamps")
def own(register):
    register("dim", 1)
"""
USES = """
from bt_manip import hookimpl

@hookimpl
def register_lamps(register):
    register("bright", {})
"""


@pytest.fixture
def load(tmp_path):
    """Load single-file plugins by name; give the plugins, and the warnings."""

    def call(**codes: str):
        for name, code in codes.items():
            (tmp_path / f"{name}.py").write_text(code)
        warned: list[str] = []
        choice = PluginSelection(folders=(tmp_path,))
        return load_plugins(entry_points=(), warn=warned.append, choice=choice), "".join(warned)

    yield call
    for name in [name for name in sys.modules if name.startswith("_bt_manip_plugin_")]:
        del sys.modules[name]


def test_plugins_register_parts_by_a_declared_hook_whichever_is_first(load):
    plugins, warned = load(b=DECLARES, a=USES.format(9), c="from _bt_manip_plugin_b import *")
    assert "it implements no hook" not in warned
    lamps = plugins.parts.of("lamps")
    assert lamps.copies() == {"bright": 9, "dim": 1}
    assert (lamps.owner("bright"), lamps.owner("dim")) == ("a", "b")
    assert plugins.parts.by_kind()["lamps"] is lamps
    assert plugins.find("a").provides == {"lamps": ("bright",)}
    assert build_station(plugins.parts).infrastructure["lamps"] is lamps
    with pytest.raises(BtManipError, match="unknown lamp 'brigh'; did you mean 'bright'"):
        lamps.get("brigh")


def test_invalid_parts_are_refused(load):
    plugins, warned = load(b=DECLARES, a=USES.format(-1))
    assert "plugin 'a' " in warned and "lamp 'bright' is no brightness" in warned
    assert plugins.parts.of("lamps").names() == ("dim",)


def test_without_the_declaring_plugin_the_hook_is_unknown_unless_it_is_optional(load):
    plugins, warned = load(a=USES.format(1))
    assert "there is no hook 'register_lamps'" in warned
    with pytest.raises(BtManipError, match="unknown kind of parts 'lamps'"):
        plugins.parts.of("lamps")
    optional = USES.format(1).replace("@hookimpl", "@hookimpl(optionalhook=True)")
    plugins, warned = load(b=optional)
    assert plugins.find("b").status == "ok" and "plugin 'b'" not in warned
    assert load(c=DECLARES, a=optional)[0].parts.of("lamps").names() == ("bright", "dim")


@pytest.mark.parametrize(
    ("code", "problem"),
    [
        (DECLARES, "it declares the hook 'register_lamps', which there is already"),
        (DECLARES.replace("register_lamps", "lamps"), "'lamps' cannot be declared"),
        (DECLARES.replace("lamps(register)", "lamps(add)"), "cannot be declared"),
        (DECLARES.replace("register_lamps", "register_robots"), "'register_robots', which there"),
    ],
)
def test_a_hook_is_declared_once_and_in_this_form(load, code, problem):
    first = DECLARES if "lamps(register):" in code and "robots" not in code else USES.format(1)
    _, warned = load(a=first, b=code)
    assert problem in warned


def test_an_entry_point_that_names_nothing_is_a_broken_plugin():
    point = EntryPoint("nothing", "bt_manip_learn.no_such_module:x", "bt_manip")
    none = EntryPoint("none", "builtins:None", "bt_manip")
    warned: list[str] = []
    plugins = load_plugins(entry_points=(point, none), warn=warned.append)
    assert [plugin.status for plugin in plugins.plugins] == ["ok", "broken", "broken"]
    assert "it implements no hook" in warned[0]
