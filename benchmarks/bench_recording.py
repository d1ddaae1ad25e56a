"""What recording and the stream of events cost a run of pick_place."""

import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from bt_manip.plugins import load_plugins
from bt_manip.recording import McapRecorder, Recorder
from bt_manip.runner import EventStream, Run, RunObserver, RunRequest, find_tree, prepare

CYCLES = 3
REPEATS = 15

Observers = Callable[[], Sequence[RunObserver]]


def _prepare() -> Run:
    parts = load_plugins().parts
    tree = find_tree("pick_place", {name: parts.trees.get(name) for name in parts.trees})
    return prepare(RunRequest(tree, cycles=CYCLES), parts)


def _duration(observers: Observers) -> float:
    """Return the processor time of a run with a report, start-up apart [s]."""
    run = _prepare()
    start = time.process_time()
    run.execute([Recorder("pick_place", 0), *observers()])
    return time.process_time() - start


def share(observers: Observers) -> float:
    """Return the median share of a run that observers add, by runs in alternation."""
    _duration(observers)
    ratios = []
    for _ in range(REPEATS):
        before = _duration(lambda: ())
        with_them = _duration(observers)
        after = _duration(lambda: ())
        ratios.append(2.0 * with_them / (before + after) - 1.0)
    return statistics.median(ratios)


def rows() -> list[tuple[str, str, str]]:
    """Give the figures: what, how much, beside what."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.mcap")
        recorded = share(lambda: [McapRecorder(path)])
        size = path.stat().st_size
    unread = share(lambda: [EventStream()])
    run = _prepare()
    run.execute()
    simulated = run.station.cell.time
    return [
        ("recording of everything, share of a run", f"{recorded:.1%}", "at most 10 %"),
        ("a stream of events that nobody reads, share of a run", f"{unread:.1%}", "at most 2 %"),
        ("size of a recording", f"{size / simulated / 1e3:.0f} kB per simulated second", ""),
    ]
