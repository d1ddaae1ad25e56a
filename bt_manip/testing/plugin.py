"""The pytest plugin: fixtures, markers and reports.

Every pytest session loads this module where bt-manip is installed, so heavy imports are made in
the fixtures.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import cache
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from bt_manip.testing.all_trees import COVERAGE, TREES

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_manip.bt import Tree
    from bt_manip.cell import Cell
    from bt_manip.plugins import Plugins
    from bt_manip.registry import Parts
    from bt_manip.robots import Robot
    from bt_manip.runner import Station
    from bt_manip.testing.situations import Situations
    from bt_manip.testing.trial import Trial

_LATEST: pytest.StashKey[Trial] = pytest.StashKey()


# Options, markers, reports


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option ``--tree-coverage``."""
    group = parser.getgroup("bt-manip")
    group.addoption(
        "--tree-coverage",
        action="store_true",
        help="show which leaves and branches of trees the tests have covered",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Register the markers."""
    for line in (
        "tree(path, substitute=None, **settings): the tree that the fixture tree_trial runs, a path"
        " beside the test or a registered name (bt-manip)",
        "start(situation): where the fixtures station, trial and tree_trial begin (bt-manip)",
        f"{TREES}(where, ...): written by bt_manip.testing.trees_of",
    ):
        config.addinivalue_line("markers", line)
    for name in _modifiers():
        line = f"in the runs of trial and tree_trial, as in bt-manip run --{name.replace('_', '-')}"
        config.addinivalue_line("markers", f"{name}(text, seed=None): {line} (bt-manip)")
    # glfw warns on machines without a display when dm_control chooses a renderer.
    config.addinivalue_line("filterwarnings", "ignore:.*DISPLAY environment variable is missing")
    if config.getoption("--tree-coverage"):
        from bt_manip.testing.coverage import TreeCoverage

        config.stash[COVERAGE] = TreeCoverage()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Parametrize tests by trees."""
    marker = metafunc.definition.get_closest_marker(TREES)
    if marker is not None:
        from bt_manip.testing.tree_runs import tree_runs

        runs = tree_runs(_plugins(), *marker.args)
        metafunc.parametrize(
            "bt_manip_tree_run", [run for _, run in runs], ids=[name for name, _ in runs]
        )


def pytest_assertrepr_compare(
    config: pytest.Config, op: str, left: object, right: object
) -> list[str] | None:
    """Explain a failed comparison of a tree's status by the last ticks."""
    trial = config.stash.get(_LATEST, None)
    if trial is None or type(left).__name__ != "NodeStatus" or op not in ("is", "=="):
        return None
    name = getattr(right, "name", right)
    return [f"{left.name} {op} {name}", *trial.explain().splitlines()]  # type: ignore[attr-defined]


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Print the coverage of trees if requested."""
    coverage = config.stash.get(COVERAGE, None)
    if coverage is not None:
        terminalreporter.section("coverage of trees")
        for line in coverage.lines():
            terminalreporter.write_line(line)


# Fixtures


@pytest.fixture(scope="session")
def parts() -> Parts:
    """All registered parts, built in and of installed plugins."""
    return _plugins().parts


@pytest.fixture
def load_plugin() -> Callable[..., Plugins]:
    """Load a plugin's module or object, and the built-in plugin, without installed ones.

    ``load_plugin(my_package.plugin).parts`` has its parts; a broken plugin is an `AssertionError`.
    """

    def load(*modules: object) -> Plugins:
        from bt_manip.plugins import PluginSelection, load_plugins

        points = [_Given(p) for p in modules]
        problems: list[str] = []
        loaded = load_plugins(entry_points=points, warn=problems.append, choice=PluginSelection())
        if problems:
            raise AssertionError("\n".join(problems))
        return loaded

    return load


@pytest.fixture(scope="session")
def build_station(parts: Parts) -> Callable[[], Station]:
    """Function that builds the station; override it in session scope for another robot or scene."""

    def build() -> Station:
        from bt_manip.plugins import build_station

        return build_station(parts)

    return build


@pytest.fixture(scope="session")
def _situations_of(build_station: Callable[[], Station]) -> Callable[..., Situations]:
    """Makes the situations of a `build_station` once, which must have session scope, too."""
    from bt_manip.testing.situations import built_in_situations

    return cache(built_in_situations)


@pytest.fixture
def situations(
    build_station: Callable[[], Station], _situations_of: Callable[..., Situations]
) -> Situations:
    """The start situations; override it, request the original and ``add`` further ones.

    In session scope, pytest would keep it where a module or folder overrides `build_station`.
    """
    return _situations_of(build_station)


@pytest.fixture
def station(situations: Situations, request: pytest.FixtureRequest) -> Station:
    """The shared station, restored to "at rest" or to the situation of the marker start."""
    marker = request.node.get_closest_marker("start")
    return situations.reset(*marker.args) if marker is not None else situations.reset()


@pytest.fixture
def cell(station: Station) -> Cell:
    """The cell of the station."""
    return station.cell


@pytest.fixture
def robot(station: Station) -> Robot:
    """The robot of the station."""
    return station.robot


@pytest.fixture
def trial(station: Station, parts: Parts, request: pytest.FixtureRequest) -> Callable[..., Trial]:
    """Run a behaviour or a tree in the station: ``trial(Hover(object="cube"))``.

    Also ``trial("pick.xml", substitute={"Grasp": Stub("FAILURE")}, force=20)``: a document
    relative to the test or a registered name, substitutes for nodes, and values of its keys.
    """

    def make(
        root: Behaviour | Tree | str | Path,
        *,
        substitute: Any = None,
        **settings: Any,
    ) -> Trial:
        from bt_manip.testing.tree_reading import read_test_tree
        from bt_manip.testing.trial import Trial

        if isinstance(root, str | Path):
            root = read_test_tree(
                root, parts, station.clock, folder=request.path.parent,
                settings=settings, substitute=substitute,
            )  # fmt: skip
        marks = {name: [*request.node.iter_markers(name)][::-1] for name in _modifiers()}
        texts = {name: tuple(mark.args[0] for mark in some) for name, some in marks.items() if some}
        seeds = [mark.kwargs["seed"] for some in marks.values() for mark in some if mark.kwargs]
        made = Trial(station, root, modifiers=texts, seed=seeds[-1] if seeds else None)
        if texts:
            request.addfinalizer(made.halt)
        request.config.stash[_LATEST] = made
        coverage = request.config.stash.get(COVERAGE, None)
        if coverage is not None and made.tree.source is not None:
            coverage.watch(made.tree)
        return made

    return make


@pytest.fixture
def tree_trial(trial: Callable[..., Trial], request: pytest.FixtureRequest) -> Iterator[Trial]:
    """The tree of the marker tree in the station; halted after the test."""
    marker = request.node.get_closest_marker("tree")
    if marker is None or len(marker.args) != 1:
        raise pytest.UsageError(
            f"{request.node.nodeid} asks for tree_trial: mark it with @pytest.mark.tree('x.xml')"
        )
    made = trial(*marker.args, **marker.kwargs)
    yield made
    made.halt()


def _modifiers() -> Collection[str]:
    """Return the names of the modifiers of installed plugins, each of which is a marker, too."""
    from bt_manip.plugins import PluginSelection, factories_of

    return factories_of("register_modifiers", PluginSelection.from_environment())


def _plugins() -> Plugins:
    from bt_manip.plugins import load_plugins

    return load_plugins()


class _Given(EntryPoint):
    """Entry point of a plugin that is imported already."""

    def __init__(self, plugin: object) -> None:
        name = str(getattr(plugin, "__name__", type(plugin).__name__))
        super().__init__(name, name, "bt_manip")
        vars(self)["plugin"] = plugin  # entry points are immutable otherwise

    def load(self) -> object:
        return vars(self)["plugin"]
