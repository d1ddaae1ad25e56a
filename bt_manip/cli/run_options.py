"""The options of ``bt-manip run``, and the run that they request."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_manip.cli.foreign_trees import ForeignTrees

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bt_manip.recording import Continuation
    from bt_manip.registry import Parts
    from bt_manip.robots import Configuration
    from bt_manip.runner import RunRequest


@dataclass(frozen=True)
class RunOptions:
    """The options of ``bt-manip run``."""

    tree: str
    cycles: int
    seed: int | None
    robot: str
    controller: str | None
    scene: str | None
    planner: str
    settings: dict[str, str]
    tick_ms: float
    real_time: float | None
    window: bool
    report: Path | None
    trace: Path | None
    records: tuple[str, ...]
    snapshots: tuple[tuple[float, Path], ...]
    resume: Path | None
    watch: bool
    quiet: bool
    groot: bool = False
    groot_port: int = 1667
    faults: tuple[str, ...] = ()
    view: bool = False
    configurations: Path | None = None
    episode: int | None = None
    foreign: ForeignTrees = field(default_factory=ForeignTrees)
    continued: "Continuation | None" = None
    """The recorded run to go on with; then the options of the request are those of this run."""

    @property
    def speed(self) -> float:
        """Simulated seconds per second of wall time at first; 0 is as fast as possible."""
        shown = self.window or self.view or self.groot
        return float(shown) if self.real_time is None else self.real_time


def make_request(
    options: RunOptions, parts: "Parts", resumed: "Mapping[str, Any] | None" = None
) -> "RunRequest":
    """Return the run that options ask for.

    Args:
        options: The options.
        parts: The registered parts.
        resumed: The snapshot that it continues from.

    Raises:
        BtManipError: If there is no such tree, or an option is out of range.
    """
    from bt_manip.runner import request_of, seed_of

    watched: dict[str, Any] = {
        "real_time": None if options.view else options.speed or None,  # the page has a control
        "reading": options.foreign.reading(),
    }
    if options.continued is not None:
        trees = {name: parts.trees.get(name) for name in parts.trees}
        return options.continued.request(trees, **watched)
    request = request_of(
        options.tree,
        parts,
        robot=options.robot,
        controller=options.controller,
        scene=options.scene,
        planner=options.planner,
        cycles=options.cycles,
        seed=options.seed,
        tick=options.tick_ms / 1e3,
        settings=options.settings,
        configurations=_configurations(options),
        **watched,
    )
    if options.seed is not None:
        return request
    seed = seed_of(request.scene, parts)
    seed = seed if resumed is None else int(resumed["request"].get("seed", seed))
    return replace(request, seed=seed)


def _configurations(options: RunOptions) -> "Mapping[str, Configuration]":
    """Return the named configurations; the page can save some in a file that is not there yet."""
    from bt_manip.robots import load_configurations

    path = options.configurations
    if path is None or (options.view and not path.exists()):
        return {}
    return load_configurations(path)
