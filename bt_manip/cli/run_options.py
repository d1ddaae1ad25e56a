"""The options of ``bt-manip run``, and the run that they request."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.foreign_trees import ForeignTrees
from bt_manip.cli.options import VARY, StationOptions, option, options_of
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts

if TYPE_CHECKING:
    from bt_manip.runner import Run, RunModifier, RunRequest


RECORDED = ("tree", "cycles", "seed", "robot", "controller", "scene", "planner", "settings")
"""Fields of a recorded request that are options of ``bt-manip run``."""

ViewOptions = Mapping[str, Mapping[str, Any]]
"""Values of the options of views, by the name of the view."""


class ContinuedRun(Protocol):
    """A recorded run that goes on from one of its moments."""

    @property
    def recording(self) -> Any:
        """The recording, which has its `path`, the run's `identity`, and `decoding`."""

    @property
    def fields(self) -> Mapping[str, Any]:
        """The request of the run, as plain data."""

    @property
    def interventions(self) -> "RunModifier":
        """A modifier that repeats the recorded interventions."""

    def request(self, trees: Mapping[str, str], **others: Any) -> "RunRequest":
        """Return the request of the recorded run, with further fields."""

    def differences(self, run: "Run") -> list[str]:
        """Return the differences from the installation that recorded the run, as warnings."""

    def simulate(self, run: "Run") -> dict[str, Any]:
        """Repeat a run up to the moment, and return its snapshot."""


@dataclass(frozen=True)
class RunOptions(StationOptions):
    """The options of ``bt-manip run``."""

    tree: str = ""
    cycles: int = option(
        "--cycles", group="Task", default=1, show_default=True, metavar="N",
        help="Runs of the tree from idle to SUCCESS or FAILURE; 0 goes on until Ctrl-C.",
    )  # fmt: skip
    episode: int | None = option(
        "--episode", group="Task", type=click.IntRange(min=0), metavar="N",
        help="Run episode N of bt-manip evaluate instead of cycles.",
    )  # fmt: skip
    seed: int | None = option(
        "--seed", group="Task", type=int, metavar="S",
        help="Seed of all randomness.  [default: the scene's, or 0]",
    )  # fmt: skip
    configurations: Path | None = option(
        "--configurations", group="Cell and robot",
        type=click.Path(path_type=Path), metavar="FILE",
        help="Named configurations for MoveToConfiguration: a TOML file, as the page saves them, "
        "or a waypoints.yaml of MoveIt Pro.",
    )  # fmt: skip
    tick_ms: float = option(
        "--tick", group="Task", default=10.0, show_default=True, metavar="MS",
        help="Simulated time between two ticks of the tree [ms].",
    )  # fmt: skip
    real_time: float | None = option(
        "--real-time", group="Views", type=click.FloatRange(min=0.0), metavar="X",
        help="Simulated seconds per second of wall time; 0 is as fast as possible.  "
        "[default: 1 with a view, else 0]",
    )  # fmt: skip
    window: bool = option(
        "--window", group="Views", is_flag=True,
        help="Show the cell in a window, which stays open after the run.",
    )  # fmt: skip
    report: Path | None = option(
        "--report", group="Files", type=click.Path(path_type=Path), metavar="FILE",
        help="Write a report as JSON; FILE.jsonl gets a line as each cycle ends.",
    )  # fmt: skip
    trace: Path | None = option(
        "--trace", group="Files", type=click.Path(path_type=Path), metavar="FILE.npz",
        help="Write t, q, v, q_ref, v_ref, a_ref and tau of every control step.",
    )  # fmt: skip
    records: tuple[str, ...] = option(
        "--record", group="Files", multiple=True, metavar="\"[NAME=]FILE KEY=VALUE ...\"",
        shell_complete=complete_part("recorders"),
        help="Add a recorder (see: bt-manip list recorders); FILE alone chooses the recorder of "
        "its suffix, as in run.mcap or run.mp4; KEY=VALUE are its options.  May be given more "
        "than once.",
    )  # fmt: skip
    varied: tuple[str, ...] = option("--vary", group="Disturbances", **VARY)
    snapshots: tuple[tuple[float, Path], ...] = option(
        "--snapshot-at", group="Files", multiple=True, metavar="SECONDS FILE",
        type=(click.FloatRange(min=0.0), click.Path(path_type=Path)),
        help="Write a snapshot after this much simulated time; may be given more than once.",
    )  # fmt: skip
    resume: Path | None = option(
        "--resume", group="Files", type=click.Path(path_type=Path), metavar="FILE",
        help="Continue from a snapshot of a run with the same options.",
    )  # fmt: skip
    backend: str = option(
        "--backend", group="Real robot", default="", metavar="NAME=ADDRESS",
        shell_complete=complete_part("backends"),
        help="Run on a real robot (see: bt-manip list backends).  [default: simulate it]",
    )  # fmt: skip
    speed_factor: float | None = option(
        "--speed", group="Real robot", type=click.FloatRange(0.0, 1.0, min_open=True), metavar="X",
        help="Factor of all speeds of the arm.  [default: 0.1 on a real robot, else 1]",
    )  # fmt: skip
    watch: bool = option(
        "--watch", group="Task", is_flag=True, help="Reload the tree whenever its file changes."
    )
    quiet: bool = option(
        "--quiet", group="Views", is_flag=True, help="Print nothing but warnings and errors."
    )
    foreign: ForeignTrees = options_of(ForeignTrees)
    views: ViewOptions = field(default_factory=dict)
    """The options of the plugins' views that are chosen, by name."""
    modifiers: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """Texts of each modifier, by name."""
    continued: ContinuedRun | None = None
    """Recorded run to continue, from which the options of the request are taken."""

    def continuing(self, continued: ContinuedRun) -> "RunOptions":
        """Return the options of a recorded run that goes on, watched as these options say."""
        recording, fields = continued.recording, continued.fields
        with recording.decoding():
            return replace(
                self,
                **{key: fields[key] for key in RECORDED},
                tick_ms=1e3 * fields["tick"],
                foreign=ForeignTrees.of(recording.identity.get("foreign", {})),
                continued=continued,
            )

    @property
    def speed(self) -> float:
        """Simulated seconds per second of wall time at first; 0 is as fast as possible."""
        shown = self.window or self.views
        return float(bool(shown)) if self.real_time is None else self.real_time


def make_request(
    options: RunOptions,
    parts: Parts,
    resumed: Mapping[str, Any] | None = None,
    *,
    by_view: bool = False,
) -> "RunRequest":
    """Return the run that options ask for.

    Args:
        options: The options.
        parts: The registered parts.
        resumed: The snapshot that it continues from.
        by_view: Whether a view controls the run: it paces it, and may save the first configurations
            in a file that is not there yet.
    """
    from bt_manip.evaluation import parse_point
    from bt_manip.robots import load_configurations
    from bt_manip.runner import request_of
    from bt_manip.scenes import seed_of

    _check(options)
    watched: dict[str, Any] = {
        "real_time": None if by_view else options.speed or None,
        "reading": replace(options.foreign.reading(), fatal_warnings=options.strict),
    }
    if options.continued is not None:
        trees = parts.trees.copies()
        return options.continued.request(trees, **watched)
    poses = options.poses or ("operator" if options.backend else None)
    file = options.configurations
    known = file is not None and (file.exists() or not by_view)
    configurations = load_configurations(file) if file is not None and known else {}
    request = request_of(
        options.tree,
        parts,
        modifiers=options.modifiers,
        cycles=options.cycles,
        seed=options.seed,
        tick=options.tick_ms / 1e3,
        configurations=configurations,
        backend=options.backend,
        speed=options.speed_factor,
        varied=parse_point(options.varied),
        **{**options.request_fields, **watched, "poses": poses},
    )
    if options.seed is not None:
        return request
    seed = seed_of(request.scene, parts)
    seed = seed if resumed is None else int(resumed["request"].get("seed", seed))
    return replace(request, seed=seed)


def _check(options: RunOptions) -> None:
    """Check that options go together, and that all requested files can be written."""
    simulated = {
        "--resume": options.resume is not None,
        "--snapshot-at": bool(options.snapshots),
        "--episode": options.episode is not None,
        "--poses physics": options.poses == "physics",
    }
    for name, given in simulated.items():
        if options.backend and given:
            raise BtManipError(f"{name} needs a simulation, not --backend {options.backend}")
    from bt_manip.record import check_writable

    wanted = [("report", options.report), ("trace", options.trace)]
    wanted += [("snapshot", path) for _, path in options.snapshots]
    taken: dict[Path, str] = {}
    for what, path in wanted:
        if path is None:
            continue
        check_writable(path, what)
        if other := taken.get(path.absolute()):
            raise BtManipError(f"{other} and {what} cannot both be '{path}'")
        taken[path.absolute()] = what
