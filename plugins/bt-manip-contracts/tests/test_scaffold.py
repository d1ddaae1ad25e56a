"""A new plugin installs, lints, and its tests pass at once; the templates are real packages."""

from pathlib import Path

import pytest

from bt_manip import hookimpl
from bt_manip.exceptions import BtManipError
from bt_manip.plugins import load_plugins
from bt_manip_contracts.scaffold import KINDS, write_plugin
from tests.support.program import run_python

NAME = "big-toothed-gear"


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> Path:
    """Write a plugin of each kind into one folder."""
    folder = tmp_path_factory.mktemp("written")
    for kind in KINDS:
        write_plugin(f"my-{kind}", kind, folder, load_plugins())
    return folder


def test_they_lint_with_long_names_too(written, tmp_path):
    run_python("-m", "ruff", "format", "--check", ".", cwd=written)
    for kind in KINDS:
        write_plugin("a" * 24, kind, tmp_path / kind, load_plugins())
    for folder in (written, tmp_path):
        run_python("-m", "ruff", "check", ".", cwd=folder)


@pytest.mark.parametrize("kinds", ["behaviour", pytest.param("*", marks=pytest.mark.soak)])
def test_they_install_and_their_tests_pass(written, tmp_path, kinds):
    packages = sorted(written.glob(f"bt-manip-my-{kinds}"))
    run_python(
        "-m", "pip", "--disable-pip-version-check", "install", "-q", "--no-index", "--no-deps",
        "--no-build-isolation", "--target", tmp_path, *packages, cwd=tmp_path,
    )  # fmt: skip
    check = run_python(
        "-m", "bt_manip", "plugins", "--check", cwd=written, PYTHONPATH=str(tmp_path)
    )
    assert "nothing is wrong" in check
    tests = ["-m", "pytest", "-q", "-p", "no:cacheprovider", "--import-mode=importlib"]
    out = run_python(*tests, *packages, cwd=written, PYTHONPATH=str(tmp_path))
    assert "passed" in out and "skipped" not in out


def test_every_name_is_put_in_everywhere(tmp_path):
    folder = write_plugin(NAME, "behaviour", tmp_path)
    assert folder == tmp_path / "bt-manip-big-toothed-gear"
    code = (folder / "bt_manip_big_toothed_gear" / "big_toothed_gear.py").read_text()
    assert "class BigToothedGear(" in code
    project = (folder / "pyproject.toml").read_text()
    assert 'big_toothed_gear = "bt_manip_big_toothed_gear.plugin"' in project
    assert 'name = "bt-manip-big-toothed-gear"' in project
    for kind in KINDS:  # the name of the part in the templates may be used, too
        gear = write_plugin("gear", kind, tmp_path / kind, load_plugins())
        assert (gear / "tests" / "test_gear.py").is_file()


NO_NAMES = ["Gear", "2fast", "a b", "-x", "class", "none", "../x", "", "x" * 40]
REFUSED = [
    *((name, "object", "the name of a plugin is") for name in NO_NAMES),
    ("cube", "object", "'cube' is registered already"),
    ("ball", "object", "'ball' is registered already, by plugin 'toys'"),
    ("builtin", "robot", "plugin 'builtin' .* is installed already"),
    ("toys", "planner", "plugin 'toys' .*is installed already"),
    ("sequence", "behaviour", "'Sequence' is a node of the tree language"),
    ("hover", "behaviour", "'Hover' is registered already"),
    ("input", "behaviour", "choose another, such as 'my-input'"),  # class Input(...): object = ...
    ("planning-result", "planner", "choose another, such as 'my-planning-result'"),
    ("pi", "robot", "choose another, such as 'my-pi'"),
    ("plugin", "object", "choose another, such as 'my-plugin'"),  # plugin.py twice
    ("cell", "controller", "choose another, such as 'my-cell'"),  # in its test
]


class toys:  # noqa: N801  the name of a plugin that is installed
    @hookimpl
    def register_objects(self, register):
        register("ball", dict)


@pytest.mark.parametrize(("name", "kind", "message"), REFUSED)
def test_what_is_no_name_or_taken_or_a_word_of_the_template_is_refused(
    load_plugin, tmp_path, name, kind, message
):
    with pytest.raises(BtManipError, match=message):
        write_plugin(name, kind, tmp_path, load_plugin(toys()))
    assert not list(tmp_path.iterdir())


def test_what_is_there_already_is_left_alone(tmp_path):
    (tmp_path / "bt-manip-wheel").mkdir()
    with pytest.raises(BtManipError, match="already"):
        write_plugin("wheel", "object", tmp_path)
    assert not list((tmp_path / "bt-manip-wheel").iterdir())
    (tmp_path / "file").write_text("")
    with pytest.raises(BtManipError, match="cannot write .*bt-manip-wheel.*: "):
        write_plugin("wheel", "object", tmp_path / "file")


def test_an_interrupt_in_the_middle_leaves_nothing_behind(tmp_path, monkeypatch):
    write = Path.write_text

    def interrupted(path, *arguments, **options):
        if path.name == "test_wheel.py":
            raise KeyboardInterrupt
        return write(path, *arguments, **options)

    monkeypatch.setattr(Path, "write_text", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_plugin("wheel", "object", tmp_path)
    assert not list(tmp_path.iterdir())
