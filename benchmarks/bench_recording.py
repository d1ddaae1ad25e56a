"""What recording, the page, Groot2 and the stream of events cost a run of pick_place."""

import contextlib
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from bt_manip.groot import GrootPublisher
from bt_manip.plugins import load_plugins
from bt_manip.recording import McapRecorder, Recorder
from bt_manip.runner import EventStream, Run, RunObserver, RunRequest, find_tree, prepare
from bt_manip.viewer import Page

CYCLES = 3
REPEATS = 15

PORT = 41667
"""Where Groot2 would connect; the next one must be free, too."""

READER = """
import asyncio, sys, viser, websockets

async def read(url):
    protocol = f"viser-v{viser.__version__}"
    async with websockets.connect(url, subprotocols=[protocol], max_size=None) as connection:
        print("open", flush=True)
        async for _ in connection:
            pass

async def main():
    await asyncio.gather(*(read(sys.argv[1]) for _ in range(int(sys.argv[2]))))

asyncio.run(main())
"""
"""Reads what pages are sent, in a process of its own, in place of browsers."""

Observers = Callable[[], Sequence[RunObserver]]


class _Clock(RunObserver):
    """Notes the processor time at the first tick [s]."""

    start: float | None = None

    def before_tick(self) -> None:
        if self.start is None:
            self.start = time.process_time()


def _prepare() -> Run:
    parts = load_plugins().parts
    tree = find_tree("pick_place", {name: parts.trees.get(name) for name in parts.trees})
    return prepare(RunRequest(tree, cycles=CYCLES), parts)


def _duration(observers: Observers) -> float:
    """Return the processor time of a run with a report, start-up apart [s]."""
    run, clock = _prepare(), _Clock()
    run.execute([Recorder("pick_place", 0), *observers(), clock])
    assert clock.start is not None
    return time.process_time() - clock.start


@contextlib.contextmanager
def _open_pages(number: int) -> Iterator[Page]:
    """Give the page of a run that some readers have opened."""
    parts = load_plugins().parts
    panels = {name: parts.panels.get(name) for name in parts.panels.in_order()}
    page = Page(panels, port=0, speed=None)
    command = [sys.executable, "-c", READER, page.url.replace("http:", "ws:"), str(number)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as readers:
        assert readers.stdout is not None
        for _ in range(number):
            readers.stdout.readline()
        yield page
        readers.kill()
    page.close()


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
    unmonitored = share(lambda: [GrootPublisher(PORT)])
    shown = {}
    for number in (0, 1, 20):
        with _open_pages(number) as page:
            shown[number] = share(lambda page=page: [page])
    run = _prepare()
    run.execute()
    simulated = run.station.cell.time
    return [
        ("recording of everything, share of a run", f"{recorded:.1%}", "at most 10 %"),
        ("a stream of events that nobody reads, share of a run", f"{unread:.1%}", "at most 2 %"),
        ("Groot2's publisher without Groot2, share of a run", f"{unmonitored:.1%}", ""),
        ("a page that is not open, share of a run", f"{shown[0]:.1%}", ""),
        ("an open page, share of a run", f"{shown[1]:.1%}", "at most 15 %"),
        ("20 open pages, share of a run", f"{shown[20]:.1%}", "at most 15 %"),
        ("size of a recording", f"{size / simulated / 1e3:.0f} kB per simulated second", ""),
    ]
