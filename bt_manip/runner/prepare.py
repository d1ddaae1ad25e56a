"""Preparing a run from a request; all errors of the request are found here."""

from collections.abc import Iterable, Mapping

from bt_manip.behaviours import check_objects
from bt_manip.bt import Declared, ReadingOptions, Tree, cannot_run
from bt_manip.exceptions import BtManipError, NodeError
from bt_manip.files import noting
from bt_manip.registry import Parts
from bt_manip.scenes import find_scene, object_models

from .observer import RunModifier
from .python_tree import make_tree
from .request import RunRequest, check_modifiers
from .run import Run
from .station import Station, make_station
from .tree_source import Clock, TreeSource
from .variation import with_varied
from .xml_tree import READING, Warn, load_document


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
        warn: Takes warnings about the tree, and those of modifiers.
        station: A station of an earlier request with the same scene and robot, to run in as it is
            now; None builds one.

    Raises:
        BtManipError: If the request is invalid.
    """
    check_modifiers(request.modifiers, request.backend, parts)
    clock, files = _StationClock(), dict[str, str]()
    with noting(files):
        request, parts = with_varied(request, parts)
        models = object_models(request.settings, find_scene(request.scene, parts))
        settings = {key: text for key, text in request.settings.items() if key not in models}
        tree = load_source(request.tree, parts, settings, clock, warn, reading=request.reading)
    stubs = [node for node in tree.nodes if isinstance(node, Declared)]
    for node in stubs:
        if not node.can_run:
            raise BtManipError(cannot_run(node))
    if stubs:
        names = sorted({f"{node.registration} ({node.effect})" for node in stubs})
        warn(f"stubs, which do not act: {', '.join(names)}")
    wanted = request.reading.stubs.results if request.reading.stubs else {}
    for name in sorted(wanted.keys() - {node.registration for node in stubs}):
        warn(f"a stub for '{name}', but no node of the tree is named so")
    clock.station = station = station or make_station(request, parts, first_cycle=True)
    for robot in station.robots.values():
        robot.robot.configurations |= request.configurations
    run = Run(request, tree, station, files=files)
    run.modifiers = make_modifiers(run, warn)
    set_up(tree, station)
    for strange in station.model_warnings():
        warn(strange)
    if station.hardware.simulated:
        run.start = station.get_state()
    return run


def set_up(tree: Tree, station: Station, more: Iterable[str] = ()) -> None:
    """Set a tree up in a station, and check the names in the cell that its ports give.

    Args:
        tree: The tree.
        station: The station.
        more: Objects that are in the cell when the tree begins.

    Raises:
        BtManipError: With the places of unknown objects, or of the first node that cannot be set
            up: for its robot, configuration or region, or a value that does not fit.
    """
    try:
        with noting(station.files):
            tree.setup(**station.infrastructure)
    except NodeError as error:  # a user error in a behaviour is one of the request
        if isinstance(error.__cause__, BtManipError):
            where = ": ".join(filter(None, (tree.place_of(error.path), error.path)))
            raise BtManipError(f"{where}: {error.__cause__}") from error
        raise
    check_objects(tree, station.infrastructure, more)


def make_modifiers(run: Run, warn: Warn = lambda message: None) -> list[RunModifier]:
    """Return the modifiers of the request of a run; raise for unknown ones and invalid texts."""
    make, expected = run.station.parts.modifiers.maker, "a RunModifier"
    return [
        make(name, "run_started", expected=expected)(run, texts, warn)
        for name, texts in run.request.modifiers.items()
    ]


def load_source(
    source: TreeSource,
    parts: Parts,
    settings: Mapping[str, str],
    clock: Clock,
    warn: Warn = lambda message: None,
    *,
    reading: ReadingOptions = READING,
) -> Tree:
    """Return the tree of a document or of a Python function.

    Args:
        source: Where the tree is.
        parts: The registered parts.
        settings: Values for some of its keys, as text.
        clock: Clock of the tree's timers [s].
        warn: Takes warnings about the tree.
        reading: How a document is read; with the clock above.

    Raises:
        BtManipError: When the tree is wrong, or a setting does not fit it.
    """
    if source.kind == "python":
        if reading.mapping is not None:
            raise BtManipError(f"--map: '{source.name}' is made in Python; it maps leaves in XML")
        return make_tree(source, settings, clock)
    return load_document(source, parts, settings, clock, warn, reading=reading)


def prepare_station(request: RunRequest, parts: Parts) -> Station:
    """Build the station of a request as for its first cycle; nothing is simulated yet."""
    return make_station(*with_varied(request, parts), first_cycle=True)


class _StationClock:
    """The simulated time of a station that is built after the tree."""

    station: Station | None = None

    def __call__(self) -> float:
        return 0.0 if self.station is None else self.station.cell.time
