"""bt-manip plugins, and the commands that plugins bring."""

import json
import sys
import textwrap

import click
import pytest

from bt_manip.cli.app import COMMANDS, app
from tests.support.program import run_python

COMMAND = '''
    import click
    {extra}


    @click.command()
    @click.argument("name")
    def greet(name):
        """Greet somebody.

        At length.
        """
        {body}
'''


HOOK = """
    from bt_manip import hookimpl

    @hookimpl
    def register_commands(register):
        register({arguments})
"""


def hook(site, name: str, arguments: str):
    """Install a package whose plugin registers a command."""
    module = f"{name.replace('-', '_')}_plugin"
    source, short = HOOK.format(arguments=arguments), name.removeprefix("bt-manip-")
    folder = site(name, "", f"[bt_manip]\n{short} = {module}\n")
    (folder / f"{module}.py").write_text(textwrap.dedent(source))
    return folder


def greeting(
    site, name: str, body: str = "click.echo(f'hello {name}')", extra: str = "", group: str = ""
):
    module = name.replace("-", "_")
    folder = hook(site, name, f"'greet', '{module}:greet', '{group}'")
    source = COMMAND.format(body=body, extra=extra)
    (folder / f"{module}.py").write_text(textwrap.dedent(source))
    return folder


def test_a_command_of_a_plugin_is_listed_with_its_first_line_and_runs(bt_manip, site):
    greeting(site, "bt-manip-polite1")
    code, out, err = bt_manip("--help")
    assert (code, err) == (0, "")
    (line,) = [line for line in out.splitlines() if "greet" in line]
    assert "Greet somebody." in line and "bt-manip-polite1" in out
    assert "bt_manip_polite1" not in sys.modules
    assert bt_manip("greet", "Ada") == (0, "hello Ada\n", "")


def test_a_command_of_a_plugin_joins_a_group(bt_manip, site):
    greeting(site, "bt-manip-polite5", group="tree")
    assert "Greet somebody. (bt-manip-polite5 2.5)" in " ".join(bt_manip("tree", "-h").out.split())
    assert bt_manip("tree", "greet", "Ada") == (0, "hello Ada\n", "")
    assert bt_manip("greet", "Ada").code == 2
    listed = bt_manip("list", "commands").out
    assert "tree-greet" in listed and "bt_manip_polite5:greet" in listed
    greeting(site, "bt-manip-polite5", group="tree", extra="import surely_not_there")
    err = bt_manip("tree", "greet", "Ada").err
    assert "the command 'tree greet' of bt-manip-polite5 2.5 cannot be loaded" in err


def test_a_command_of_an_entry_point_runs_with_a_warning_that_names_the_hook(bt_manip, site):
    source = COMMAND.format(body="click.echo(f'hello {name}')", extra="")
    points = "[bt_manip.commands]\ngreet = bt_manip_polite7:greet\n"
    site("bt-manip-polite7", source, points)
    assert "Greet somebody. (bt-manip-polite7 2.5)" in " ".join(bt_manip("--help").out.split())
    code, out, err = bt_manip("greet", "Ada")
    assert (code, out) == (0, "hello Ada\n")
    (line,) = err.splitlines()
    assert line.startswith(
        "Warning: the package bt-manip-polite7 2.5 registers the command 'greet'"
    )
    assert "deprecated: use the hook register_commands" in line
    assert bt_manip("--block", "polite7", "greet", "Ada").code == 2


def test_a_blocked_command_is_not_there(bt_manip, site, monkeypatch):
    greeting(site, "bt-manip-polite2")
    assert "greet" not in bt_manip("--block", "polite2", "--help").out
    assert bt_manip("--block", "polite2", "greet", "Ada").code == 2
    monkeypatch.setenv("BT_MANIP_BLOCK", "bt-manip-polite2")
    assert bt_manip("greet", "Ada").code == 2


LOADING = "the command 'greet' of bt-manip-rude 2.5 cannot be loaded: "


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"extra": "import surely_not_there"}, f"{LOADING}ModuleNotFoundError: No module named"),
        ({"extra": "raise SystemExit(0)"}, f"{LOADING}SystemExit: 0 (to block it: --block rude)"),
        ({"body": "raise ValueError('no')"}, "a command of bt-manip-rude 2.5: ValueError: no"),
    ],
)
def test_a_command_that_fails_is_3_and_says_whose_it_is(bt_manip, site, options, problem):
    greeting(site, "bt-manip-rude", **options)
    assert bt_manip("--help").code == 0
    code, _, err = bt_manip("greet", "Ada")
    assert code == 3 and err.splitlines()[-1].startswith(f"Error: {problem}")


def test_what_is_no_command_is_3(bt_manip, site):
    hook(site, "bt-manip-odd", "'greet', 'sys:maxsize'")
    code, _, err = bt_manip("greet")
    assert code == 3 and "is not a click command" in err


def test_no_plugin_takes_the_place_of_a_built_in_command(bt_manip, site):
    hook(site, "bt-manip-thief", "'list', 'sys:maxsize'")
    assert "table_and_basket" in bt_manip("list", "scenes").out


def test_help_loads_none_of_twenty_plugins(site):
    for i in range(20):
        heavy = "import mujoco\n" if i == 7 else ""
        module = f"bt_manip_many{i}"
        folder = hook(site, f"bt-manip-many{i}", f"'many{i}', '{module}:main'")
        (folder / f"{module}.py").write_text(f"{heavy}raise RuntimeError('loaded')\n")
    code = (
        "import sys\n"
        "from bt_manip.cli.app import run_app\n"
        "from bt_manip.cli.interrupt import Interrupt\n"
        "assert run_app(Interrupt(), ['--help']) == 0\n"
        "dear = {'mujoco', 'numpy', 'importlib.metadata', 'bt_manip.plugins.loading'}\n"
        "assert not dear & set(sys.modules), dear & set(sys.modules)\n"
        "modules = [m for m in sys.modules if m.startswith('bt_manip_many')]\n"
        "assert all(m.endswith('_plugin') for m in modules), modules\n"
    )
    shown = run_python("-c", code, cwd=folder, PYTHONPATH=str(folder))
    assert all(f"many{i}" in shown for i in range(20))


TOYS = """
    from bt_manip import hookimpl


    @hookimpl
    def register_objects(register):
        register("toy_{0}", dict)


    @hookimpl
    def after_tick(tree):
        pass
"""


def test_plugins_are_shown_with_what_they_bring(bt_manip, site):
    site("bt-manip-toys", TOYS.format(1), "[bt_manip]\ntoys = bt_manip_toys\n")
    site("bt-manip-bad", "import nothing_like_it", "[bt_manip]\nbad = bt_manip_bad\n")
    code, out, err = bt_manip("plugins", "--json", "--block", "impedance")
    assert (code, err) == (0, "")
    rows = {row["name"]: row for row in json.loads(out)["plugins"]}
    assert rows["toys"]["version"] == "2.5"
    assert rows["toys"]["package"] == "bt-manip-toys"
    assert rows["toys"]["provides"] == {"objects": ["toy_1"]}
    assert rows["toys"]["observers"] == ["after_tick"]
    assert rows["toys"]["source"].endswith("bt_manip_toys.py")
    assert [rows[name]["status"] for name in ("builtin", "toys", "bad", "impedance")] == [
        "ok", "ok", "broken", "blocked",
    ]  # fmt: skip
    assert "nothing_like_it" in rows["bad"]["problem"]
    code, out, err = bt_manip("plugins")
    assert (code, err) == (0, "")
    assert "toys 2.5: ok" in out and "objects: toy_1" in out and "bad 2.5: broken" in out


def all_commands(command: click.Command, words: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    if not isinstance(command, click.Group):
        return [words]
    context = click.Context(command)
    found = [words] if words else []
    for name in command.list_commands(context):
        one = command.get_command(context, name)
        found += all_commands(one, (*words, name))
    return found


def test_every_command_says_which_plugins_to_load_and_shows_its_help_cleanly(bt_manip):
    built_in = [words for words in all_commands(app) if words[0] in COMMANDS]
    assert ("tree", "check") in built_in and ("models", "fetch") in built_in
    for words in built_in:
        code, out, _ = bt_manip(*words, "--help")
        assert code == 0
        assert out.count("--plugins-dir DIR") == out.count("--block NAME") == 1, words
        assert "\\b" not in out and "\b" not in out


def test_an_option_behind_a_sub_command_loads_its_plugins(bt_manip, task, tmp_path):
    (tmp_path / "one.py").write_text(textwrap.dedent(TOYS.format(7)))
    tree = task("<MoveHome/>")
    assert bt_manip("tree", "check", tree, "--plugins-dir", tmp_path).code == 0
    outcome = bt_manip("tree", "check", tree, "--block", "impedence")
    assert "Warning: --block impedence: there is no such plugin" in outcome.err


def test_a_check_is_3_when_anything_is_broken_and_says_what(bt_manip, site):
    site("bt-manip-bad2", "import nothing_like_it", "[bt_manip]\nbad2 = bt_manip_bad2\n")
    greeting(site, "bt-manip-rude3", extra="import surely_not_there")
    code, _, err = bt_manip("plugins", "--check")
    assert code == 3
    assert "plugin 'bad2' 2.5" in err and "nothing_like_it" in err
    assert "the command 'greet' of bt-manip-rude3 2.5" in err
    code, out, err = bt_manip("plugins", "--check", "--block", "bad2", "--block", "rude3")
    assert (code, err) == (0, "") and "nothing is wrong" in out


def test_a_name_to_block_that_nothing_has_is_told_with_the_nearest(bt_manip, site):
    greeting(site, "bt-manip-polite4")
    for command in (["list", "scenes"], ["plugins"], ["plugins", "--check"]):
        code, _, err = bt_manip(*command, "--block", "impedence", "--block", "polite4")
        assert code == 0
        (line,) = err.splitlines()
        assert line.startswith("Warning: --block impedence: there is no such plugin; did you mean ")
        assert "'impedance'" in line
    assert "cannot be blocked" in bt_manip("list", "scenes", "--block", "builtin").err


def test_a_check_reads_trees_and_looks_for_where_they_work(bt_manip, site, task):
    tree = task("<Graps/>")
    source = f"""
        from bt_manip import hookimpl

        @hookimpl
        def register_trees(register):
            register("typo", {str(tree)!r}, scene="two_tabels", controller="computed_torq")
    """
    site("bt-manip-forest", source, "[bt_manip]\nforest = bt_manip_forest\n")
    code, _, err = bt_manip("plugins", "--check")
    assert code == 3
    scene, controller, name = err.splitlines()
    assert all(line.startswith("Warning: plugin 'forest' 2.5 (") for line in err.splitlines())
    assert "tree 'typo': unknown scene 'two_tabels'" in scene
    assert "unknown controller 'computed_torq'; did you mean 'computed_torque'" in controller
    assert "task.xml:3:1" in name and "no node is named 'Graps'" in name


def test_a_command_that_prints_when_it_is_imported_leaves_the_json_alone(bt_manip, site):
    greeting(site, "bt-manip-loud", extra="print('here I am')")
    code, out, err = bt_manip("plugins", "--json")
    assert code == 0 and json.loads(out) and err == "here I am\n"
