"""Whoever asks for a name in a package that is missing is told the package."""

import importlib
import re
from collections import defaultdict
from pathlib import Path

import pytest

from bt_manip import __version__
from bt_manip.bt import BehaviourRegistry, parse_tree
from bt_manip.exceptions import TreeError
from bt_manip.packages import MovedModules, missing, packages
from bt_manip.parameters import parameters_of
from bt_manip.plugins import load_plugins
from bt_manip.runner import RunRequest, make_station
from tests.support.pages import required_packages
from tests.support.program import run_program


def install(package: str) -> str:
    """Return the end of a message: it installs what its pyproject.toml requires from here, too."""
    folders = " ".join(f"./plugins/{each}" for each in (*required_packages(package), package))
    return f"needs the package {package}: pip install {folders} (in a clone)"


def registered() -> dict[str, dict[str, set[str]]]:
    """Return the names that each package of the repository registers, by kind."""
    plugins = load_plugins()
    kinds = {field: registry.kind for field, registry in plugins.parts.by_kind().items()}
    parts, found = plugins.parts, defaultdict(lambda: defaultdict(set))
    for plugin in plugins.plugins:
        names = found[plugin.package]
        for field, provided in plugin.provides.items():
            names[kinds[field]] |= {*provided}
        for name in plugin.provides.get("recorders", ()):
            suffix = parts.recorders.get(name).suffix
            names["file"] |= {suffix} if isinstance(suffix, str) else {*suffix}
        for name in plugin.provides.get("views", ()):
            keys = parameters_of(parts.views.get(name), keyword_only=True)
            names["option"] |= {f"--{name}", *(f"--{name}-{key}" for key in keys)}
        for name in plugin.provides.get("model_formats", ()):
            form = parts.model_formats.get(name)
            names["file"] |= {*form.suffixes, form.tag} - {""}
        for name in plugin.provides.get("dialects", ()):
            own = {*parts.dialects.get(name).nodes} - {*BehaviourRegistry().names()}
            if own:
                names["node of a dialect"] |= own
        if plugin.package:
            module = vars(importlib.import_module(plugin.module))
            hooks = {name for name, value in module.items() if hasattr(value, "bt_manip_spec")}
            kinds_of = {name.removeprefix("register_") for name in hooks}
            names |= {"hook": hooks, "kind of parts": kinds_of} if hooks else {}
    return {package: dict(names) for package, names in found.items()}


def test_the_table_has_the_names_that_each_package_registers():
    named = {name: {k: {*v.split()} for k, v in of.items()} for name, of in packages().items()}
    assert named["bt-manip-fuel"]["file"] > {"model.config"}
    named["bt-manip-fuel"]["file"].remove("model.config")  # by which a folder is recognised
    for kinds in named.values():
        kinds.pop("module", None)
        kinds.pop("requires", None)
    here = Path(__file__).resolve().parents[1] / "plugins"
    folders = {path.parent.name for path in here.glob("*/pyproject.toml")}
    plugins = load_plugins().plugins
    assert {each.version for each in plugins if each.package in folders} == {__version__}
    assert {name: kinds for name, kinds in registered().items() if name in folders} == named


def test_no_name_of_a_kind_is_in_two_packages():
    names = [
        (kind, name)
        for kinds in packages().values()
        for kind, text in kinds.items()
        for name in text.split()
    ]
    assert len(names) == len({*names})
    assert missing(None, "ur5e") == missing("robot", "ur5e") == install("bt-manip-menagerie")
    assert missing("tree", "ur5e") == missing("nothing", "ur5e") == missing(None, "ur") == ""


BLOCKED = ",".join(package.removeprefix("bt-manip-") for package in packages())


@pytest.mark.parametrize(
    ("arguments", "package"),
    [
        ("run pick_place --groot", "groot"),
        ("run pick_place --groot-port 1667", "groot"),
        ("run pick_place --record run.btlog", "groot"),
        ("run pick_place --view-port 0", "view"),
        ("run pick_place --record mcap=run.mcap", "recording"),
        ("run pick_place --fault push", "stress"),
        ("evaluate pick_place --fault push", "stress"),
        ("list faults", "stress"),
        ("evaluate pick_place --ray", "learn"),
        ("demos info DIR", "learn"),
        ("run pick_place --robot ur5e", "menagerie"),
        ("run sort_blocks", "blocks"),
        ("run pick_place --scene peg_on_table", "impedance"),
        ("run pick_place --controller joint_impedance", "impedance"),
        ("run pick_place --planner lazy_roadmap", "roadmap"),
        ("run pick_place --backend franka=host", "franka"),
        ("list robots ur5e", "menagerie"),
        ("list drawer", "impedance"),
        ("new plugin gear", "contracts"),
        ("tree convert pick_place", "convert"),
        ("models path fuel:a/b", "fuel"),
        ("models list fuel", "fuel"),
    ],
)
def test_the_command_line_names_the_package(arguments, package, capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BT_MANIP_BLOCK", BLOCKED)
    assert run_program(*arguments.split()) == 2
    assert install(f"bt-manip-{package}") in capfd.readouterr().err


def test_objects_and_behaviours_of_trees_name_the_package():
    parts = load_plugins(entry_points=()).parts
    station = make_station(RunRequest(robot="panda"), parts)
    with pytest.raises(Exception, match=re.escape(install("bt-manip-everyday"))):
        station.models.get("bowl")
    text = '<root BTCPP_format="4"><BehaviorTree ID="Main"><Press/></BehaviorTree></root>'
    with pytest.raises(TreeError, match="no node is named 'Press'; it needs") as caught:
        parse_tree(text, BehaviourRegistry())
    assert install("bt-manip-impedance") in str(caught.value)


@pytest.mark.parametrize(
    ("former", "new", "package"),
    [
        ("groot", "bt_manip_groot", "bt-manip-groot"),
        ("robot_setup", "bt_manip_setup", "bt-manip-setup"),
        ("record.video", "bt_manip_view.video", "bt-manip-view"),
        ("faults", "bt_manip_stress.faults", "bt-manip-stress"),
    ],
)
def test_the_import_of_a_former_module_names_the_new_one_and_its_package(former, new, package):
    message = f"bt_manip.{former} is now {new}, and {install(package)}"
    with pytest.raises(ImportError, match=re.escape(message)):
        importlib.import_module(f"bt_manip.{former}")
    assert MovedModules.find_spec("bt_manip.nothing") is None


@pytest.mark.parametrize(
    ("module", "name", "new"),
    [
        ("evaluation", "results_page", "view"),
        ("cell", "CellScene", "recording"),
        ("evaluation", "StressTester", "stress"),
        ("testing", "DEVICE_CONTRACT", "contracts"),
        ("evaluation", "RayPool", "learn"),
        ("grippers", "NativeTwoFingerGripper", "learn"),
        ("robots", "verify", "contracts"),
        ("cell.objects", "Peg", "impedance"),
    ],
)
def test_a_name_that_has_moved_names_the_new_one_and_its_package(module, name, new):
    message = f"bt_manip.{module}.{name} is now bt_manip_{new}.{name}, and needs the package bt-man"
    with pytest.raises(ImportError, match=message):
        exec(f"from bt_manip.{module} import {name}")
