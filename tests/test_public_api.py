"""What the API page lists exists, and everything that is shown to users imports nothing else."""

import ast
import importlib
import inspect
import re
import subprocess
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

import pytest

import bt_manip
from bt_manip.bt.nodes import Node
from bt_manip.plugins import load_plugins
from bt_manip_learn.commands import DEMONSTRATION_FORMATS
from tools import api_page, key_page

REPOSITORY = Path(__file__).resolve().parent.parent

BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("package", api_page.names())
def test_every_documented_name_is_on_the_page_with_its_summary(package):
    text = api_page.page().partition(f"\n## `{package}`\n")[2].partition("\n## ")[0]
    for name, stability in api_page.names()[package].items():
        assert f"| `{name}` | {stability} | " in text


@pytest.mark.parametrize("path", key_page.PAGES, ids=lambda path: path.stem)
def test_the_pages_of_keys_are_up_to_date(path):
    assert path.read_text() == key_page.PAGES[path](), "run python tools/key_page.py"


def tracked(*paths: str) -> list[str]:
    """Give the names of the files of these paths."""
    command = ["git", "ls-files", "--", *paths]
    done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=True)
    return done.stdout.split()


def shown_code(*paths: str) -> list[tuple[str, str]]:
    """Give name and text of the Python code that users are shown or given."""
    found = []
    for name in tracked(*paths):
        path = REPOSITORY / name
        if path.suffix == ".py":
            found.append((name, path.read_text()))
        elif path.suffix == ".md":
            text = path.read_text()
            for block in BLOCK.finditer(text):  # on its lines of the page
                found.append((name, "\n" * text.count("\n", 0, block.start(1)) + block[1]))
    return found


ROOTS = {package.split(".")[0] for package in api_page.names()}
"""Import names of the distributions that the API page lists."""


BY_TEXT = ("setattr", "import_module", "importorskip")
"""Functions that take a module, or a name in one, as text."""


class Used(NamedTuple):
    """A name of another module, empty for the module itself, and the line that uses it."""

    line: int
    module: str
    name: str


def imported(code: str) -> list[Used]:
    """Give the names that code uses of documented packages: imports, attributes and texts."""
    try:
        nodes = list(ast.walk(ast.parse(code)))
    except SyntaxError:  # an excerpt
        return []
    found, modules = [], {}
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and node.module is not None:
            found += [Used(node.lineno, node.module, alias.name) for alias in node.names]
            for alias in node.names:
                modules[alias.asname or alias.name] = f"{node.module}.{alias.name}"
        elif isinstance(node, ast.Import):
            found += [Used(node.lineno, alias.name, "") for alias in node.names]
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], ast.Constant):
            if ast.unparse(node.func).endswith(BY_TEXT):
                found.append(Used(node.lineno, *str(node.args[0].value).rpartition(".")[::2]))
    for node in nodes:
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            module = modules.get(node.value.id)
            if module in api_page.names():
                found.append(Used(node.lineno, module, node.attr))
    return [one for one in found if one.module.split(".")[0] in ROOTS]


WITH_A_CLIENT = "bt_manip_learn.envs.stable_baselines"
"""Cannot be imported where Stable-Baselines3 is not installed; the page on environments has it."""


def test_examples_tutorials_templates_and_plugins_import_documented_names_only():
    documented = api_page.names()
    code = shown_code("docs", "examples", "templates", "plugins", "README.md")
    assert len(code) > 50
    private = [
        f"{where}:{line}: {module} {name} is private".replace("  ", " ")
        for where, text in code
        for line, module, name in imported(text)
        if name not in documented.get(module, {})
        and f"{module}.{name}".rstrip(".") not in documented
        and module != WITH_A_CLIENT
        and module.split(".")[0] not in where.replace("-", "_").split("/")  # a package's own
    ]
    assert not private, "\n".join(private)


GUIDES = (
    "README.md", "docs/start.md", "docs/authoring-python.md", "docs/testing.md", "docs/howto",
    "docs/plugins", "plugins/bt-manip-learn/README.md", "templates", "examples",
)  # fmt: skip
"""Where users learn what to import."""

TREES = ("trees", "plugins/*.xml")
"""Where the trees are that come with packages."""


def named_nodes() -> set[str]:
    """Give the words that trees and guides name as nodes: ``<Lift .../>`` or as code."""
    names = [name for name in tracked(*GUIDES, *TREES) if name.endswith((".md", ".xml"))]
    texts = [(REPOSITORY / name).read_text() for name in names]
    return {word for text in texts for word in re.findall(r"[<`](\w+)", text)}


def test_the_stable_names_are_those_that_guides_import_and_nodes_that_they_or_trees_name():
    """Errors are stable if a guide catches them; the other ones are `BtManipError` to users."""
    guides = {one[1:] for _, text in shown_code(*GUIDES) for one in imported(text)}
    nodes, expected, stable = named_nodes(), set(), set()
    for package, names in api_page.names().items():
        for name, stability in names.items():
            thing = getattr(importlib.import_module(package), name)
            is_node = inspect.isclass(thing) and issubclass(thing, Node)
            if (package, name) in guides or (is_node and name in nodes):
                expected.add(f"{package}.{name}")
            if stability == "stable":
                stable.add(f"{package}.{name}")
    missing, surplus = sorted(expected - stable), sorted(stable - expected)
    assert not missing, f"move to STABLE in tools/api_page.py: {missing}"
    assert not surplus, f"no guide or tree names them; move to EXPERIMENTAL: {surplus}"


def test_every_built_in_behaviour_is_documented():
    registered = load_plugins().working("builtin").provides["behaviours"]
    missing = {*registered} - {*api_page.names()["bt_manip.behaviours"]}
    assert not missing, f"add to 'bt_manip.behaviours' in tools/api_page.py: {sorted(missing)}"


def test_the_writers_of_all_formats_of_demonstrations_are_documented():
    writers = {one.write for one in DEMONSTRATION_FORMATS.values()}
    missing = writers - {*api_page.names()["bt_manip_learn.demonstrations"]}
    assert not missing, f"add to the demonstrations in tools/api_page.py: {sorted(missing)}"


def test_the_version_is_that_of_the_installed_package():
    assert bt_manip.__version__ == version("bt-manip")
