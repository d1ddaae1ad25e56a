"""The layers and the public interface of the package are what the architecture page says."""

import ast
import importlib
import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.support.program import run_python

REPOSITORY = Path(__file__).resolve().parent.parent
PACKAGE = REPOSITORY / "bt_manip"

LAYERS = (
    {
        "bt", "models", "parameters", "toml",
        "exceptions", "files", "hookspecs", "packages", "registry", "spatial", "version",
    },
    {"robots", "cell"},
    {"kinematics", "collision", "trajectories"},
    {"planning", "control", "grippers"},
    {"arm", "grasping"},
    {"behaviours"},
    {"scenes", "runner"},
    {"viewer", "record"},
    {"plugins", "builtin"},
    {"testing", "evaluation"},
    {"cli"},
)  # fmt: skip
"""Packages and single modules by layer, from the lowest."""

WITHIN_LAYER = {
    ("bt", "exceptions"),
    ("models", "exceptions"),
    ("models", "spatial"),
    ("parameters", "exceptions"),
    ("bt", "parameters"),
    ("toml", "parameters"),
    ("registry", "exceptions"),
    ("packages", "exceptions"),
    ("registry", "packages"),
    ("bt", "packages"),
    ("models", "packages"),
    ("models", "registry"),
    ("bt", "files"),
    ("bt", "toml"),
    ("models", "files"),
    ("toml", "exceptions"),
    ("toml", "files"),
    ("toml", "spatial"),
    ("robots", "cell"),
    ("kinematics", "collision"),
    ("grasping", "arm"),
    ("runner", "scenes"),
    ("plugins", "builtin"),
    ("testing", "evaluation"),
}
"""Imports inside a layer: which package, and what it may import."""


BESIDE = {"__main__", "__init__"}
"""Modules beside the layers."""


class Import(NamedTuple):
    """One name, empty for ``import a.b``, that a module imports from the package."""

    importer: str
    module: str
    name: str
    line: int

    def __str__(self) -> str:
        return f"{self.importer}:{self.line} imports {self.module} {self.name}".rstrip()


def module_name(path: Path) -> str:
    parts = path.relative_to(REPOSITORY).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def modules() -> dict[str, Path]:
    return {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}


@cache
def packages() -> frozenset[str]:
    return frozenset(name for name, path in modules().items() if path.name == "__init__.py")


def is_type_checking(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Give all statements that run, also those of functions."""
    for statement in body:
        if is_type_checking(statement):
            continue
        yield statement
        for field in ("body", "orelse", "finalbody"):
            yield from statements(getattr(statement, field, []))
        for handler in getattr(statement, "handlers", []):
            yield from statements(handler.body)


def source_of(statement: ast.ImportFrom, package: str) -> str:
    """Give the module that a module of a package imports from."""
    parts = package.split(".")
    base = ".".join(parts[: len(parts) - statement.level + 1]) if statement.level else ""
    return ".".join(filter(None, (base, statement.module)))


def imports_of(path: Path, importer: str) -> Iterator[Import]:
    """Give what a file imports from bt_manip, except what only type checkers see."""
    package = importer if path.name == "__init__.py" else importer.rpartition(".")[0]
    for statement in statements(ast.parse(path.read_text()).body):
        if isinstance(statement, ast.Import):
            for alias in statement.names:
                if alias.name.split(".")[0] == "bt_manip":
                    yield Import(importer, alias.name, "", statement.lineno)
        elif isinstance(statement, ast.ImportFrom):
            module = source_of(statement, package)
            if module.split(".")[0] != "bt_manip":
                continue
            for alias in statement.names:
                submodule = f"{module}.{alias.name}"
                exported = module in packages() and alias.name in exports(module)
                is_module = submodule in modules() and not exported
                found = (submodule, "") if is_module else (module, alias.name)
                yield Import(importer, *found, statement.lineno)


@cache
def imports() -> tuple[Import, ...]:
    return tuple(found for name, path in modules().items() for found in imports_of(path, name))


def top_of(module: str) -> str:
    """Give the package or single module below bt_manip that a module belongs to."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else "__init__"


def layer_of(top: str) -> int:
    return next(i for i, layer in enumerate(LAYERS) if top in layer)


EXPORTED_EVERYWHERE = ("hookimpl", "__version__", "lazy_exports")
"""Names of the package itself that all layers may import."""


def may_import(top: str, other: str) -> bool:
    """Tell whether a package or single module may import another one."""
    if other in BESIDE:
        return False
    return layer_of(other) < layer_of(top) or (top, other) in WITHIN_LAYER


def test_a_module_imports_only_from_layers_below():
    wrong = []
    for found in imports():
        top, other = top_of(found.importer), top_of(found.module)
        anywhere = other == "__init__" and found.name in EXPORTED_EVERYWHERE
        if top not in BESIDE | {other} and not anywhere and not may_import(top, other):
            wrong.append(str(found))
    assert not wrong, "\n".join(wrong)


STEPPING = {
    "bt_manip.runner.hardware",
    "bt_manip.testing.situations",
}
"""Modules that call `Cell.step`."""


def test_the_hardware_alone_makes_control_steps():
    found = {
        name
        for name, path in modules().items()
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call)
        and function_of(node) == "step"
        and ast.unparse(node.func).endswith("cell.step")
    }
    assert found == STEPPING


def test_one_table_alone_names_packages_of_plugins():
    packages = [path.parent.name for path in (REPOSITORY / "plugins").glob("*/pyproject.toml")]
    assert {"bt-manip-fuel", "bt-manip-learn"} <= {*packages}
    pattern = re.compile(rf"\b({'|'.join(packages)})\b".replace("-", "[-_]"))
    found = [
        f"{path.relative_to(REPOSITORY)}:{line}: {named[0]}"
        for path in modules().values()
        if path != PACKAGE / "packages.py"
        for line, text in enumerate(path.read_text().splitlines(), 1)
        for named in pattern.finditer(text)
    ]
    assert not found, "\n".join(found)


def test_every_package_is_in_a_layer():
    tops = {top_of(name) for name in modules()}
    assert tops <= set().union(*LAYERS) | BESIDE


def defining_module(module: str, name: str) -> str:
    """Follow exports of packages to the module that defines a name."""
    while module in packages() and name:
        source = exports(module).get(name)
        if source is None:
            break
        module, name = source
    return module


@cache
def exports(package: str) -> dict[str, tuple[str, str]]:
    """Give what a package's __init__ exports: by name, the module and the name there."""
    found = {}
    tree = ast.parse(modules()[package].read_text())
    for statement in ast.walk(tree):  # inside TYPE_CHECKING too: lazy exports stand there
        if isinstance(statement, ast.ImportFrom):
            module = source_of(statement, package)
            for alias in statement.names:
                found[alias.asname or alias.name] = (module, alias.name)
    return found


def test_no_modules_import_each_other():
    graph = {name: set() for name in modules()}
    for found in imports():
        # A package's __init__ only exports: who imports a name from it needs the defining module.
        if found.importer not in packages():
            graph[found.importer].add(defining_module(found.module, found.name))
    list(TopologicalSorter(graph).static_order())  # or a `CycleError` that names them


def test_imports_between_packages_go_through_the_init_of_the_other_package():
    bypassing = [
        str(found)
        for found in imports()
        if top_of(found.importer) not in BESIDE
        and top_of(found.importer) != top_of(found.module)
        and found.module.count(".") > 1
        and found.module not in packages()
    ]
    assert not bypassing, "\n".join(bypassing)


def test_no_class_name_is_defined_twice():
    where = defaultdict(list)
    for name, path in modules().items():
        for statement in ast.parse(path.read_text()).body:
            if isinstance(statement, ast.ClassDef) and not statement.name.startswith("_"):
                where[statement.name].append(name)
    twice = {name: places for name, places in where.items() if len(places) > 1}
    assert not twice


def test_public_constants_of_one_name_have_one_value():
    values = defaultdict(set)
    for path in modules().values():
        for statement in ast.parse(path.read_text()).body:
            if not isinstance(statement, ast.Assign | ast.AnnAssign) or statement.value is None:
                continue
            target = getattr(statement, "target", None) or statement.targets[0]
            if isinstance(target, ast.Name) and target.id.isupper() and target.id[0] != "_":
                values[target.id].add(ast.unparse(statement.value))
    del values["SUCCESS"]  # the usual name of a status and of an exit code
    assert not {name: found for name, found in values.items() if len(found) > 1}


LAZY = (
    "bt_manip", "bt_manip.cli", "bt_manip.evaluation", "bt_manip.plugins", "bt_manip.record",
    "bt_manip.testing", "bt_manip.viewer",
)  # fmt: skip
"""Packages that import what they export when it is first used."""


def test_an_init_only_exports_names():
    for package in packages() - set(LAZY):
        docstring, *rest = ast.parse(modules()[package].read_text()).body
        assert isinstance(docstring, ast.Expr), package
        names_moved = ast.parse("__getattr__ = lazy_exports(__name__)").body
        if rest and ast.dump(rest[-1]) == ast.dump(names_moved[0]):
            rest.pop()
        assert all(isinstance(statement, ast.ImportFrom) for statement in rest), package


@pytest.mark.parametrize("package", LAZY)
def test_what_type_checkers_see_in_a_package_is_exported_on_demand(package):
    body = ast.parse(modules()[package].read_text()).body
    (checked,) = (statement for statement in body if is_type_checking(statement))
    module = importlib.import_module(package)
    for name in (alias.name for found in checked.body for alias in found.names):
        assert getattr(module, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'load_plugin'"):
        _ = module.load_plugin


HEAVY = ("mujoco", "pinocchio", "dm_control", "numpy", "rich", "lxml", "py_trees")


def loaded_after(code: str) -> list[str]:
    """Run code in a new interpreter; give which of the heavy packages it has loaded."""
    script = f"{code}\nimport sys; print([m for m in {HEAVY!r} if m in sys.modules])"
    return ast.literal_eval(run_python("-c", script, cwd=REPOSITORY).splitlines()[-1])


@pytest.mark.parametrize("arguments", [[], ["run"], ["list"], ["tree"]], ids=" ".join)
def test_help_loads_nothing_heavy(arguments):
    code = (
        "from bt_manip.cli.app import run_app\n"
        "from bt_manip.cli.interrupt import Interrupt\n"
        f"assert run_app(Interrupt(), {[*arguments, '--help']!r}) == 0"
    )
    assert loaded_after(code) == []


def test_a_plugins_marker_costs_nothing():
    assert loaded_after("from bt_manip import hookimpl") == []


@pytest.mark.parametrize("display", [pytest.param("", marks=pytest.mark.soak), ":9999"])
def test_without_a_display_the_library_imports_silently(display, monkeypatch):
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setenv("DISPLAY", display)
    code = "import os, bt_manip.runner; print(os.environ.get('MUJOCO_GL'))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "None\n", "")


PUBLIC_BY_PROTOCOL = {
    "_replace", "_asdict", "_fields", "_name_", "_value_", "_exit",  # named tuples, Enum, os
    "_repr_html_", "_repr_png_", "_repr_svg_", "_build",  # notebooks, composer.Entity
}  # fmt: skip
TESTS_WITH_PRIVATE_NAMES = {
    "plugins/bt-manip-franka/tests/simulated_franka.py",  # extends the simulator of libfranka
    "plugins/bt-manip-trossen/tests/simulated_widowx.py",  # extends the simulator of the driver
    "tests/bt/test_nodes.py",  # timers that pile up are not seen otherwise
    "tests/collision/test_conservative_advancement.py",  # inflates bodies as other robots are
    "tests/support/corpus_leaves.py",  # a leaf of the reference
    "tests/conformance/runner.py",  # fires timers between ticks
    "tests/evaluation/test_results.py",  # leaves a folder as a killed process does
}


def function_of(call: ast.Call) -> str:
    """Return the last name of the function that is called."""
    return getattr(call.func, "attr", "") or getattr(call.func, "id", "")


def private_names(path: Path) -> Iterator[tuple[int, str]]:
    """Yield lines and private names of other objects that a file uses, imports or patches."""
    for node in ast.walk(ast.parse(path.read_text())):
        names: list[object] = []
        if isinstance(node, ast.Attribute):
            own = isinstance(node.value, ast.Name) and node.value.id in ("self", "cls")
            names = [] if own else [node.attr]
        elif isinstance(node, ast.ImportFrom):
            names = [one.name for one in node.names]
        elif isinstance(node, ast.Call) and function_of(node).endswith(("setattr", "getattr")):
            names = [one.value for one in node.args if isinstance(one, ast.Constant)]
        for name in (str(name).rpartition(".")[2] for name in names):
            if re.match("_[a-z]", name, re.IGNORECASE) and name not in PUBLIC_BY_PROTOCOL:
                yield node.lineno, name


def test_tests_use_no_private_names():
    for path in sorted(
        [*REPOSITORY.glob("tests/**/*.py"), *REPOSITORY.glob("plugins/*/tests/*.py")]
    ):
        if (name := str(path.relative_to(REPOSITORY))) not in TESTS_WITH_PRIVATE_NAMES:
            assert not [f"{name}:{line}: {one}" for line, one in private_names(path)]
