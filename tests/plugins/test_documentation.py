"""Every hook has a page whose example works, and a test; tutorials show their packages."""

import inspect
import re
import runpy
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from bt_manip import hookspecs
from bt_manip.models import bundled_root
from bt_manip.registry import Parts
from bt_manip.robots import read_description
from tests.support.program import run_python

TUTORIALS = ("object", "controller", "robot", "behaviour", "planner")
DOCS = Path(__file__).resolve().parents[2] / "docs" / "plugins"
HOOKS = (*hookspecs.REGISTERING, *hookspecs.OBSERVING)


PAGES = (*hookspecs.REGISTERING, "observers")


def page(hook: str) -> str:
    """Give the page of a hook that registers, or the section of one that observes."""
    if hook in hookspecs.REGISTERING:
        return (DOCS / "hooks" / f"{hook}.md").read_text()
    text = (DOCS / "hooks" / "observers.md").read_text()
    (section,) = re.findall(rf"^#(# `{hook}\(.*?)(?=^## |\Z)", text, re.DOTALL | re.MULTILINE)
    return section


def test_every_function_among_the_hooks_is_one_of_them():
    functions = {name for name, f in vars(hookspecs).items() if inspect.isfunction(f)}
    assert functions == set(HOOKS)
    assert set(hookspecs.REGISTERING) == {f"register_{kind}" for kind in Parts().by_kind()}


@pytest.mark.parametrize("hook", HOOKS)
def test_a_hook_has_a_page_with_its_exact_signature(hook):
    parameters = ", ".join(inspect.signature(getattr(hookspecs, hook)).parameters)
    assert page(hook).splitlines()[0] == f"# `{hook}({parameters})`"
    whole = page(hook)
    if hook in hookspecs.OBSERVING:
        whole += (DOCS / "hooks" / "observers.md").read_text().partition("\n## ")[0]
    for name in parameters.split(", "):
        assert f"`{name}" in whole


@pytest.mark.parametrize("hook", HOOKS)
def test_a_hook_has_a_test(hook):
    tests = Path(__file__).with_name("test_each_hook.py").read_text()
    assert f"\ndef test_{hook}_" in tests


def test_there_is_a_page_for_nothing_else():
    assert {path.stem for path in (DOCS / "hooks").iterdir()} == set(PAGES)
    assert {path.stem for path in (DOCS / "tutorials").iterdir()} == set(TUTORIALS)


def test_the_first_page_leads_to_all_others():
    links = set(
        re.findall(r"\]\(((?:hooks|tutorials)/\w+\.md)\)", (DOCS / "README.md").read_text())
    )
    assert links == {f"hooks/{name}.md" for name in PAGES} | {
        f"tutorials/{k}.md" for k in TUTORIALS
    }


@pytest.mark.parametrize("kind", TUTORIALS)
def test_the_code_of_a_tutorial_is_that_of_the_package_which_ci_runs(kind):
    """The packages themselves are written, installed and tested in test_scaffold.py."""
    page = DOCS / "tutorials" / f"{kind}.md"
    shown = re.findall(
        r"## `([\w/.]+)`\n[^#]*?```\{literalinclude\} (\S+)\n```", page.read_text(), re.DOTALL
    )
    assert [name for name, _ in shown] == ["bt_manip_gear/gear.py"]
    for name, file in shown:
        assert (page.parent / file).samefile(bundled_root("templates") / kind / name)


SINGLE_FILE = """
from bt_manip import hookimpl

@hookimpl
def register_scenes(register):
    pass
"""


def test_the_pyproject_of_the_first_page_installs_a_single_file(tmp_path):
    (text,) = re.findall(r"```toml\n(\[project\]\n.*?)```", (DOCS / "README.md").read_text(), re.S)
    (module,) = tomllib.loads(text)["tool"]["setuptools"]["py-modules"]
    source, target = tmp_path / "source", tmp_path / "target"
    source.mkdir()
    (source / "pyproject.toml").write_text(text)
    (source / f"{module}.py").write_text(SINGLE_FILE)
    (source / f"test_{module}.py").touch()
    run_python(
        "-m", "pip", "--disable-pip-version-check", "install", "-q", "--no-index", "--no-deps",
        "--no-build-isolation", "--target", target, source, cwd=tmp_path,
    )  # fmt: skip
    listed = run_python("-m", "bt_manip", "plugins", cwd=tmp_path, PYTHONPATH=str(target))
    assert f"{module} 0.1: ok" in listed


def test_the_robot_tutorials_file_describes_the_robot_of_its_package(tmp_path):
    _, _, page = (DOCS / "tutorials" / "robot.md").read_text().partition("## Without a package")
    template = bundled_root("templates") / "robot" / "bt_manip_gear"
    shutil.copy(template / "gear.xml", tmp_path)
    (code,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    (tmp_path / "gear.toml").write_text(code)
    described = runpy.run_path(str(template / "gear.py"))["gear"]()
    parameters = {key: v for key, v in described.gripper.parameters.items() if key != "travel"}
    read = read_description(tmp_path / "gear.toml")
    assert read == replace(
        described, model=str(tmp_path / "gear.xml"), T_ft=read.T_ft, T_rb=read.T_rb,
        gripper=replace(described.gripper, T_mg=read.gripper.T_mg, parameters=parameters),
    )  # fmt: skip
    for T in (read.T_ft, read.T_rb, read.gripper.T_mg):
        assert T.isIdentity()
