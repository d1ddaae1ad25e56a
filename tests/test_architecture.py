"""The house stands as it was planned: imports go down, and names are handed on."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from bt_manip import plugins

PACKAGE = Path(__file__).resolve().parent.parent / "bt_manip"

FLOORS = (
    {
        "checks",
        "exceptions",
        "hookspecs",
        "registry",
        "spatial",
        "toml_lines",
        "toml_tables",
    },
    {"bt", "models"},
    {"robots", "cell"},
    {"kinematics", "collision", "trajectories"},
    {"planning", "control"},
    {"arm"},
    {"grasping"},
    {"behaviours"},
    {"runner"},
    {"viewer", "recording", "testing"},
    {"cli"},
)
"""Rooms by floor, from the ground up."""

BESIDE = {
    ("checks", "exceptions"),
    ("kinematics", "collision"),
    ("registry", "exceptions"),
    ("toml_tables", "exceptions"),
    ("toml_tables", "spatial"),
    ("toml_tables", "toml_lines"),
}
"""Imports inside a floor: whose room, and whose room it may know."""

TOP = {"plugins", "builtin", "__main__", "__init__"}
"""Modules that stand at the top of the package, beside the floors: they bring it together."""


def floor_of(room: str) -> int:
    return next(i for i, rooms in enumerate(FLOORS) if room in rooms)


def modules() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


def room_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported_rooms(path: Path) -> Iterator[tuple[int, str, bool]]:
    """Give line, room and whether it is deferred for each import of the package in a module."""
    tree = ast.parse(path.read_text())
    at_top = {id(node) for statement in tree.body for node in shallow(statement)}
    package = ("bt_manip", *path.relative_to(PACKAGE).parent.parts)
    for node in ast.walk(tree):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ".".join(package[: len(package) - node.level + 1]) if node.level else ""
            module = ".".join(filter(None, (base, node.module)))
            is_package = module == "bt_manip"
            names = [f"{module}.{alias.name}" if is_package else module for alias in node.names]
        for name in names:
            parts = name.split(".")
            if parts[0] == "bt_manip" and len(parts) > 1:
                yield node.lineno, parts[1], id(node) not in at_top


def shallow(statement: ast.stmt) -> Iterator[ast.AST]:
    """Walk through what runs at import: not into functions, nor what only type checkers see."""
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef):
        return
    if isinstance(statement, ast.If) and ast.unparse(statement.test) == "TYPE_CHECKING":
        return
    yield statement
    for child in ast.iter_child_nodes(statement):
        if isinstance(child, ast.stmt):
            yield from shallow(child)


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_a_module_imports_only_from_floors_below(path):
    room = room_of(path)
    if room in TOP:
        return
    for line, other, deferred in imported_rooms(path):
        if other == room or (other == "hookimpl" and not deferred):
            continue
        where = f"{path.name}:{line} imports {other}"
        if other in TOP:
            # Who needs all parts may ask for them when it runs; only the command line, which
            # stands above everything, knows them at import.
            at_import = room == "cli" and other == "plugins"
            assert (deferred or at_import) and floor_of(room) >= floor_of("runner"), where
            continue
        below = floor_of(other) < floor_of(room)
        assert below or (room, other) in BESIDE, where


def test_every_room_stands_on_a_floor():
    rooms = {room_of(path) for path in modules()}
    assert rooms <= set().union(*FLOORS) | TOP


@pytest.mark.parametrize(
    "path",
    [path for path in modules() if path.name == "__init__.py" and path.parent != PACKAGE],
    ids=lambda path: path.parent.name,
)
def test_an_init_only_hands_names_on(path):
    body = ast.parse(path.read_text()).body
    assert isinstance(body[0], ast.Expr)  # the docstring
    if path.parent.name == "plugins":  # what is dear is handed on when it is asked for
        body = [statement for statement in body if not hands_on_lazily(statement)]
    assert all(isinstance(statement, ast.ImportFrom) for statement in body[1:])


def hands_on_lazily(statement: ast.stmt) -> bool:
    """Tell whether it is part of a module's `__getattr__`, its table or its import."""
    if isinstance(statement, ast.FunctionDef):
        return statement.name == "__getattr__"
    if isinstance(statement, ast.If):  # for type checkers
        return all(isinstance(inner, ast.ImportFrom) for inner in statement.body)
    return isinstance(statement, ast.Assign | ast.Import)


def test_what_is_handed_on_when_asked_for_is_what_type_checkers_see():
    path = PACKAGE / "plugins" / "__init__.py"
    (checked,) = (s for s in ast.parse(path.read_text()).body if isinstance(s, ast.If))
    names = [alias.name for statement in checked.body for alias in statement.names]
    assert len(names) == 6
    for name in names:
        assert getattr(plugins, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'load_plugin'"):
        _ = plugins.load_plugin


HEAVY = ("mujoco", "pinocchio", "dm_control", "numpy", "rich", "lxml", "py_trees")


def loaded_after(code: str) -> list[str]:
    """Run code in a new interpreter; give which of the heavy packages it has loaded."""
    script = f"{code}\nimport sys; print([m for m in {HEAVY!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return ast.literal_eval(done.stdout.splitlines()[-1])


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
