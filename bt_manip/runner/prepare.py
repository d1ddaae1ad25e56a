"""Preparing a run from a request; all errors of the request are found here."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from bt_manip.bt import Tree
from bt_manip.cell.objects import Catalogue
from bt_manip.exceptions import BtManipError, NodeError
from bt_manip.registry import Parts
from bt_manip.scenes import find_scene, naming_file, object_models, with_models

from .python_tree import make_tree
from .request import RunRequest
from .run import Run
from .station import Station, make_station
from .tree_source import Clock, TreeSource
from .xml_tree import Warn, check_can_run, known_behaviours, load_document


def prepare(
    request: RunRequest,
    parts: Parts,
    warn: Warn = lambda message: None,
    station: Station | None = None,
) -> Run:
    """Load the tree, build the station and set the tree up; nothing is simulated yet.

    Args:
        request: The tree, the scene and the parts to use.
        parts: The registered parts to choose from.
        warn: Takes warnings about the tree.
        station: A station of an earlier request with the same scene and robot, to run in as it is
            now; None builds one.

    Raises:
        BtManipError: If the request is invalid.
    """
    clock = _StationClock()
    scene = find_scene(request.scene, parts)
    models = object_models(request.settings, scene)
    settings = {key: text for key, text in request.settings.items() if key not in models}
    tree = load_source(request.tree, parts, settings, clock, warn, reading=request.reading)
    check_can_run(tree, warn)
    clock.station = station = station or prepare_station(request, parts)
    for robot in station.robots.values():
        robot.robot.configurations |= request.configurations
    _setup(tree, station)
    for lost in station.models.warnings():
        warn(lost)
    return Run(request, tree, station)


def load_source(
    source: TreeSource,
    parts: Parts,
    settings: Mapping[str, str],
    clock: Clock,
    warn: Warn = lambda message: None,
    *,
    reading: Mapping[str, Any] | None = None,
) -> Tree:
    """Return the tree of a document or of a Python function.

    Args:
        source: Where the tree is.
        parts: The registered parts.
        settings: Values for some of its keys, as text.
        clock: Clock of the tree's timers [s].
        warn: Takes warnings about the tree.
        reading: Further options of `bt_manip.bt.read_tree`, of documents.

    Raises:
        BtManipError: When the tree is wrong, or a setting does not fit it.
    """
    if source.kind == "python":
        return make_tree(source, settings, clock)
    return load_document(source, known_behaviours(parts), settings, clock, warn, reading=reading)


def prepare_station(request: RunRequest, parts: Parts) -> Station:
    """Build the station of a request; nothing is simulated yet.

    Args:
        request: The scene and the parts to use.
        parts: The registered parts to choose from.

    Raises:
        BtManipError: If the request is invalid.
    """
    scene = find_scene(request.scene, parts)
    models = object_models(request.settings, scene)
    catalogue = Catalogue(parts.objects, sources=parts.model_sources, formats=parts.model_formats)
    if models:
        request = replace(request, scene=with_models(scene, models, catalogue))
    station = make_station(request, parts, catalogue)
    with naming_file(scene):
        station.randomizer.begin(0)  # draws that are impossible are found now
    return station


def _setup(tree: Tree, station: Station) -> None:
    """Set the behaviours up; a user error in one is raised as such, with the node's path."""
    try:
        tree.setup(**station.infrastructure)
    except NodeError as error:
        if isinstance(error.__cause__, BtManipError):
            raise BtManipError(f"{error.path}: {error.__cause__}") from error
        raise


class _StationClock:
    """The simulated time of a station that is built after the tree."""

    station: Station | None = None

    def __call__(self) -> float:
        return 0.0 if self.station is None else self.station.cell.time
