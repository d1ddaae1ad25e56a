"""Plugins come in whole or not at all."""

import pytest

from bt_manip.exceptions import BtManipError
from bt_manip.plugins import PluginWarning, load_plugins
from bt_manip.registry import PartFault, Registry, UnknownPartError

GOOD = """
    @hookimpl
    def register_objects(register):
        register("ball", lambda: "a ball")
    @hookimpl
    def register_controllers(register):
        register("soft", lambda robot: robot)
"""


def test_a_plugin_brings_parts_that_know_where_they_are_from(plugin, load):
    plugins, warnings = load(plugin("toys", GOOD))
    assert warnings == []
    assert plugins.parts.objects.create("ball") == "a ball"
    assert plugins.parts.objects.owner("ball") == "toys"
    assert plugins.parts.objects.owner("cube") == "builtin"
    assert plugins.parts.controllers.names() == ("soft",)
    toys = plugins.plugins[1]
    assert toys.provides == {"objects": ("ball",), "controllers": ("soft",)}
    assert toys.problem == ""
    assert toys.source.endswith(".py")


def test_a_registry_hands_out_copies_and_offers_the_nearest_name():
    registry: Registry[dict] = Registry("robot")
    registry.add("panda", {"home": [0.0]}, "builtin")
    registry.get("panda")["home"].append(1.0)
    assert registry.get("panda") == {"home": [0.0]}
    with pytest.raises(UnknownPartError, match="unknown robot 'pand'; did you mean 'pa") as caught:
        registry.get("pand")
    assert caught.value.known == ("panda",)


def hook(signature: str, *body: str) -> str:
    return "@hookimpl\n" + "\n    ".join((f"def {signature}:", *body))


BROKEN = {
    "import error": ("import no_such_module_anywhere", "no_such_module_anywhere"),
    "syntax error": ("def broken(:", "SyntaxError"),
    "exit at import": ("raise SystemExit(5)", "SystemExit: 5"),
    "wrong signature": (
        hook("register_objects(register, physics)", 'register("x", dict)'),
        "physics",
    ),
    "misspelt argument": (
        hook("register_objects(regster)", 'regster("x", dict)'),
        "'register_objects' is not given 'regster', which it takes; did you mean 'register'",
    ),
    "no argument": (
        hook("register_objects()", "pass"),
        "'register_objects' does not take 'register'",
    ),
    "generator": (
        hook("register_objects(register)", 'register("x", dict)', "yield"),
        "'register_objects' has a yield in it",
    ),
    "coroutine": (
        "@hookimpl\nasync def after_tick(tree): pass",
        "'after_tick' is async",
    ),
    "register called wrongly": (
        hook("register_objects(register)", 'register("x")'),
        "register(name, factory) was called wrongly: missing a required argument: 'factory'",
    ),
    "misspelt hook": (
        hook("register_objets(register)", 'register("x", dict)'),
        "there is no hook 'register_objets'; did you mean 'register_objects'",
    ),
    "misspelt observer": (hook("after_tik(tree)", "pass"), "did you mean 'after_tick'"),
    "misspelt category": (
        """
        class Odd:
            category = "graspble"
        @hookimpl
        def register_objects(register): register("odd", Odd)
        """,
        "object 'odd': category 'graspble' is none; did you mean 'graspable'?",
    ),
    "unknown kind": (
        """
        class Odd:
            kind = "od"
        @hookimpl
        def register_objects(register): register("odd", Odd)
        """,
        "object 'odd' has the kind 'od', from which a snapshot could not recreate it; "
        "did you mean 'odd'?",
    ),
    "name of another plugin's part": (
        hook("register_objects(register)", 'register("x", dict)', 'register("cube", dict)'),
        "object 'cube' is registered already, by plugin 'builtin'",
    ),
    "its own name twice": (
        hook("register_objects(register)", 'register("x", dict)', 'register("x", list)'),
        "registers object 'x' twice",
    ),
    "raising hook": (
        hook("register_objects(register)", 'register("x", dict)\n')
        + hook("register_robots(register)", 'raise RuntimeError("no arm today")'),
        "RuntimeError: no arm today",
    ),
    "earlier name of a hook": (
        hook("initialize_episode(station)", "pass"),
        "the hook 'initialize_episode' is now called 'cycle_started'",
    ),
    "no hook marked": ("def register_objects(register): pass", "implements no hook"),
    "wrapper": (
        "@hookimpl(wrapper=True)\ndef register_objects(register): return (yield)",
        "wraps other plugins' hooks",
    ),
    "not callable": (
        hook("register_objects(register)", 'register("x", 3)'),
        "'x' among its objects is not callable",
    ),
    "no name": (hook("register_objects(register)", 'register("a b", dict)'), "letters, digits"),
    "abstract class": (
        """
        import abc
        class Thing(abc.ABC):
            @abc.abstractmethod
            def mjcf_model(self): pass
        @hookimpl
        def register_objects(register): register("x", Thing)
        """,
        "'x' among its objects is incomplete: it lacks mjcf_model",
    ),
    "behaviour without update": (
        """
        from bt_manip.bt import Action
        class Idle(Action): pass
        @hookimpl
        def register_behaviours(register): register(Idle)
        """,
        "behaviour 'Idle' has no 'update'",
    ),
    "behaviour that spells initialise otherwise": (
        """
        from bt_manip.bt import Action
        class Begin(Action):
            def initialize(self): pass
            def update(self): pass
        @hookimpl
        def register_behaviours(register): register(Begin)
        """,
        "did you mean 'initialise'?",
    ),
    "no robot": (
        hook("register_robots(register)", 'register("panda")'),
        "a robot is a RobotDescription",
    ),
    "no behaviour": (hook("register_behaviours(register)", "register(dict)"), "dict"),
    "no tree": (
        hook("register_trees(register)", 'register("x", "nowhere.xml")'),
        "tree 'x': 'nowhere.xml'",
    ),
}


@pytest.mark.parametrize(("source", "reason"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_plugin_is_one_warning_and_nothing_of_it_stays(plugin, load, source, reason):
    plugins, warnings = load(plugin("broken", source), plugin("toys", GOOD))
    assert len(warnings) == 1
    assert warnings[0].startswith("plugin 'broken'")
    assert reason in warnings[0]
    assert "\n" not in warnings[0]
    assert plugins.parts.objects.names() == ("ball", "cube")
    assert [p.name for p in plugins.plugins if p.problem] == ["broken"]


def test_the_line_of_the_plugin_is_told_where_something_is_wrong(plugin, load):
    source = hook("register_objects(register)", 'register("x", dict)', 'register("cube", dict)')
    point = plugin("broken", source)
    _, (warning,) = load(point)
    assert f"by plugin 'builtin', at {point.load().__file__}:5 (" in warning


def test_what_a_plugin_prints_does_not_get_among_the_output(plugin, load, capsys):
    source = """
        print("importing")
        @hookimpl
        def register_objects(register):
            print("registering")
            register("ball", dict)
    """
    plugins, warnings = load(plugin("chatty", source))
    assert warnings == [] and "ball" in plugins.parts.objects
    assert capsys.readouterr() == ("", "importing\nregistering\n")


def test_the_place_of_a_tree_holds_when_the_folder_changes(plugin, load, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.xml").write_text("<root/>")
    source = hook("register_trees(register)", 'register("mine", "mine.xml")')
    plugins, _ = load(plugin("trees", source))
    assert plugins.parts.trees.get("mine") == str(tmp_path / "mine.xml")


def test_of_two_plugins_with_one_name_the_second_is_left_out(plugin, load):
    first, second = plugin("toys", GOOD), plugin("toys", GOOD.replace("ball", "kite"))
    plugins, warnings = load(second, first)
    assert len(warnings) == 1
    assert "another plugin has the same name" in warnings[0]
    assert plugins.parts.objects.names() == ("ball", "cube")


def test_a_plugin_called_builtin_does_not_take_its_place(plugin, load):
    plugins, warnings = load(plugin("builtin", GOOD))
    assert len(warnings) == 1
    assert plugins.parts.objects.names() == ("cube",)


def test_an_interrupt_during_an_import_is_not_swallowed(plugin, load):
    with pytest.raises(KeyboardInterrupt):
        load(plugin("slow", "raise KeyboardInterrupt"))


def test_nothing_can_be_registered_after_the_hook(plugin, load):
    late = hook("register_objects(register)", "kept.append(register)")
    point = plugin("late", f"kept = []\n{late}")
    plugins, _ = load(point)
    with pytest.raises(Exception, match="inside the hook"):
        point.load().kept[0]("afterwards", dict)
    assert plugins.parts.objects.names() == ("cube",)


def test_a_missing_name_is_explained_by_a_broken_plugin(plugin, load):
    plugins, _ = load(plugin("broken", "raise RuntimeError"))
    with pytest.raises(Exception, match=r"unknown object 'bal'.*plugin 'broken'"):
        plugins.parts.objects.get("bal")


def test_without_somebody_to_tell_a_broken_plugin_is_a_python_warning(plugin):
    point = plugin("broken", "raise RuntimeError")
    builtin = plugin("tiny", GOOD).load()
    with pytest.warns(PluginWarning, match="plugin 'broken'"):
        load_plugins(entry_points=[point], builtin=builtin)


def test_blame_falls_on_the_plugin_whose_code_raised(plugin, load):
    toys = """
        def thrower(): raise ValueError("too heavy")
        @hookimpl
        def register_objects(register): register("stone", thrower)
    """
    plugins, _ = load(plugin("toys", toys))
    with pytest.raises(ValueError, match="too heavy") as caught:
        plugins.parts.objects.create("stone")
    blamed = plugins.blame(caught.value)
    assert blamed is not None
    assert blamed.name == "toys"


def test_nobody_is_blamed_for_what_no_plugin_did(load):
    plugins, _ = load()
    with pytest.raises(ZeroDivisionError) as caught:
        1 / 0  # noqa: B018
    assert plugins.blame(caught.value) is None


@pytest.mark.parametrize(
    ("factory", "problem"),
    [
        ("lambda: 3", "its factory gave a int, which has no 'plan'"),
        ("lambda: {}['size']", "KeyError: 'size'"),
        ("lambda robot: 3", "TypeError: .* missing 1 required positional argument: 'robot'"),
    ],
)
def test_a_part_that_cannot_be_made_is_blamed_on_its_plugin(plugin, load, factory, problem):
    source = hook("register_planners(register)", f'register("odd", {factory})')
    plugins, _ = load(plugin("toys", source))
    with pytest.raises(PartFault, match=f"^planner 'odd' cannot be made: {problem}$") as caught:
        plugins.parts.planners.maker("odd", "plan")()
    blamed = plugins.blame(caught.value)
    assert blamed is not None and blamed.name == "toys"


def test_bad_input_of_a_part_that_is_made_stays_bad_input(plugin, load):
    toys = """
        from bt_manip.exceptions import BtManipError
        def choosy(path): raise BtManipError("needs a file")
        @hookimpl
        def register_recorders(register): register("choosy", choosy)
    """
    plugins, _ = load(plugin("toys", toys))
    with pytest.raises(BtManipError, match="^needs a file$"):
        plugins.parts.recorders.maker("choosy")(None)
