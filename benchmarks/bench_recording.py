"""What recording, the page, Groot2 and the stream of events cost a run of pick_place."""

import contextlib
import statistics
import subprocess
import sys
import tempfile
import time
import timeit
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from bt_manip.plugins import load_plugins
from bt_manip.record import Recorder
from bt_manip.runner import EventQueue, Run, RunObserver, RunRequest, find_tree, prepare
from bt_manip_groot.publisher import GrootPublisher
from bt_manip_recording import McapRecorder
from bt_manip_view import Page

CYCLES = 3
REPEATS = 15

PORT = 41667
"""Where Groot2 would connect; the next one must be free, too."""

READER = """
import asyncio, sys, viser, websockets

PROTOCOLS = {"scene": f"viser-v{viser.__version__}", "page": "bt-manip"}

async def read(what, index):
    url, protocol = f"{sys.argv[1]}/{what}", PROTOCOLS[what]
    async with websockets.connect(url, subprotocols=[protocol], max_size=None) as connection:
        print("open", flush=True)
        if index < int(sys.argv[3]):
            await asyncio.sleep(3600)
        async for _ in connection:
            pass

async def main():
    await asyncio.gather(*(read(what, i) for i in range(int(sys.argv[2])) for what in PROTOCOLS))

asyncio.run(main())
"""
"""Reads what pages are sent, in a process of its own, in place of browsers; some never read."""

TREE = """<root BTCPP_format="4"><BehaviorTree ID="Main"><Fallback>
  <Repeat num_cycles="500"><Sequence><Sleep msec="10"/><AlwaysSuccess/></Sequence></Repeat>{nodes}
</Fallback></BehaviorTree></root>
"""
"""A tree of which the same nodes run for some seconds, whatever ``nodes`` follow."""

CALLS = (
    "after_compile", "cycle_started", "before_tick", "after_step", "after_tick", "cycle_ended",
    "run_ended", "_status_changed",
)  # fmt: skip
"""Methods of an observer that are called during a run."""

Observers = Callable[[], Sequence[RunObserver]]


class _Clock(RunObserver):
    """Notes the times of process and thread at the first tick [s]."""

    start: float | None = None
    thread_start = 0.0

    def before_tick(self) -> None:
        if self.start is None:
            self.start, self.thread_start = time.process_time(), time.thread_time()


def _prepare(tree: str = "pick_place") -> Run:
    parts = load_plugins().parts
    source = find_tree(tree, {name: parts.trees.get(name) for name in parts.trees})
    return prepare(RunRequest(source, cycles=CYCLES), parts)


def _duration(observers: Observers) -> float:
    """Return the processor time of a run with a report, start-up apart [s]."""
    run, clock = _prepare(), _Clock()
    run.execute([Recorder("pick_place", 0), *observers(), clock])
    assert clock.start is not None
    return time.process_time() - clock.start


@contextlib.contextmanager
def _open_pages(number: int, stalled: int = 0) -> Iterator[Page]:
    """Give the page of a run that some readers have opened, of which some never read."""
    registered = load_plugins().parts.of("panels")
    panels = {name: registered.get(name) for name in registered.in_order()}
    page = Page(panels, port=0, speed=None)
    url = page.url.replace("http:", "ws:")
    command = [sys.executable, "-c", READER, url, str(number), str(stalled)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as readers:
        assert readers.stdout is not None
        for _ in range(2 * number):  # page and scene
            assert readers.stdout.readline() == b"open\n"
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


def _timed(observer: RunObserver, clock: _Clock) -> list[float]:
    """Let an observer add up the processor time of its calls; return the sum as a list [s]."""
    total = [0.0]
    clock_time = min(timeit.repeat(time.thread_time, repeat=100, number=10)) / 10  # of a reading

    def wrapped(call: Callable[..., None]) -> Callable[..., None]:
        def timed(*arguments: Any) -> None:
            start = time.thread_time()
            call(*arguments)
            if clock.start is not None:
                total[0] += time.thread_time() - start - clock_time

        return timed

    for name in CALLS:
        if getattr(type(observer), name, None) is not getattr(RunObserver, name, None):
            setattr(observer, name, wrapped(getattr(type(observer), name).__get__(observer)))
    return total


def _spent(observers: Observers, tree: str = "pick_place") -> tuple[float, float, float]:
    """Return times of a run: of the observers' calls, of all else in its thread, of others [s]."""
    run, clock, watching = _prepare(tree), _Clock(), observers()
    totals = [_timed(observer, clock) for observer in watching]
    run.execute([Recorder("pick_place", 0), *watching, clock])
    assert clock.start is not None
    thread = time.thread_time() - clock.thread_start
    calls = sum(total for (total,) in totals)
    return calls, thread - calls, time.process_time() - clock.start - thread


def cost(observers: Observers, tree: str = "pick_place") -> float:
    """Return the median share of a run that observers take, in their calls and their threads.

    The times of whole runs vary by more than this: a share within one run does not.
    """
    _spent(observers, tree)  # sends the geometry
    plain = [_spent(lambda: (), tree) for _ in range(REPEATS)]
    others = statistics.median(other / run for _, run, other in plain)
    watched = [_spent(observers, tree) for _ in range(REPEATS)]
    return statistics.median((calls + other) / run - others for calls, run, other in watched)


def _large_trees() -> dict[int, float]:
    """Return the share of a run that an open page takes, by the number of nodes of the tree."""
    shares = {}
    with tempfile.TemporaryDirectory() as folder, _open_pages(1) as page:
        for number in (20, 500):
            path = Path(folder, f"nodes{number}.xml")
            path.write_text(TREE.format(nodes="<AlwaysSuccess/>" * (number - 5)))
            shares[number] = cost(lambda: [page], str(path))
    return shares


def rows() -> list[tuple[str, str, str]]:
    """Give the figures: what, how much, beside what."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.mcap")
        recorded = share(lambda: [McapRecorder(path)])
        size = path.stat().st_size
    unread = cost(lambda: [EventQueue(size=1)])
    unmonitored = cost(lambda: [GrootPublisher(PORT)])
    shown = {}
    for number in (0, 1, 20):
        with _open_pages(number, stalled=number // 20) as page:
            shown[number] = cost(lambda page=page: [page])
    nodes = _large_trees()
    run = _prepare()
    run.execute()
    simulated = run.station.cell.time
    return [
        ("recording of everything, share of a run", f"{recorded:.1%}", "at most 10 %"),
        ("a stream of events that nobody reads, share of a run", f"{unread:.1%}", "at most 2 %"),
        ("Groot2's publisher without Groot2, share of a run", f"{unmonitored:.1%}", ""),
        ("a page that is not open, share of a run", f"{shown[0]:.1%}", ""),
        ("an open page, share of a run", f"{shown[1]:.1%}", "at most 15 %"),
        ("20 open pages, one of which does not read", f"{shown[20]:.1%}", "at most 5 % above one"),
        ("an open page of 20 nodes, share of a run", f"{nodes[20]:.1%}", ""),
        ("an open page of 500 nodes, share of a run", f"{nodes[500]:.1%}", "as of 20 nodes"),
        ("size of a recording", f"{size / simulated / 1e3:.0f} kB per simulated second", ""),
    ]
