"""Many pages on one run, one of which does not read, need no more memory as time goes on."""

import gc
import random
import subprocess
import sys
import threading
import time
import tracemalloc

import numpy as np
import pytest

from bt_manip.behaviours import RemoveObject, SpawnObject
from bt_manip.bt import Sequence, Sleep
from bt_manip.runner import RunObserver
from bt_manip_view.page import server as page_server

from .conftest import PROTOCOLS

READERS = """
import asyncio, sys, websockets

async def read(index):
    what, protocol = sys.argv[3:]
    address = f"{sys.argv[1]}/{what}"
    async with websockets.connect(address, subprotocols=[protocol], max_size=None) as page:
        print("open", flush=True)
        if index == 0:
            await asyncio.sleep(3600)
        async for data in page:
            if index == 1:
                print(len(data), file=sys.stderr, flush=True)

async def main():
    await asyncio.gather(*map(read, range(int(sys.argv[2]))))

asyncio.run(main())
"""
"""Opens pages or scenes, the first of which does not read; writes how much the second gets."""

PAGES = 8

TEXT = 200_000
"""Number of characters that are sent at each tick besides what is shown."""


BUFFERED = 40e6
"""Number of bytes after which a page that does not read has stalled: more than a socket buffers."""

SENT = 4e6
"""Number of bytes that a page gets during the measurement, after another one has stalled."""


@pytest.fixture(params=PROTOCOLS)
def received(page, request):
    """Open the pages in a process of their own; give the sizes of what the second one gets."""
    address, what = page.url.replace("http:", "ws:"), request.param
    arguments = [address, str(PAGES), what, PROTOCOLS[what]]
    command = [sys.executable, "-c", READERS, *arguments]
    sizes = []
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        for _ in range(PAGES):
            assert process.stdout.readline() == "open\n"
        thread = threading.Thread(target=lambda: sizes.extend(map(int, process.stderr)))
        thread.start()
        yield sizes
        process.kill()
        thread.join()


class Memory(RunObserver):
    """Lets much be sent at each tick; measures memory and what was received after each cycle."""

    def __init__(self, page, received):
        self.page, self.received = page, received
        self.text = page.gui.add_html("")
        self.sizes, self.sums = [], []  # [bytes], since a page does not read

    def after_tick(self):
        text = random.randbytes(TEXT // 2).hex()
        self.page.server.gui.set_panel_label(text)
        self.text.content = text
        self.page.refresh(now=True)
        time.sleep(0.02)

    def cycle_ended(self, status, reason):
        if sum(self.received) > BUFFERED:
            gc.collect()
            self.sizes.append(tracemalloc.get_traced_memory()[0])
            self.sums.append(sum(self.received))

    def has_ended(self):
        return len(self.sums) > 5 and self.sums[-3] - self.sums[2] > SENT


@pytest.mark.soak
def test_eight_pages_one_of_which_does_not_read_keep_memory_flat(
    make_run, page, received, monkeypatch
):
    monkeypatch.setattr(page_server, "STALLED", 1000.0)
    root = Sequence(SpawnObject(object="{cube}"), Sleep(msec=100), RemoveObject(object="{cube}"))
    memory = Memory(page, received)
    tracemalloc.start()
    try:
        make_run(root, cycles=200).execute([page, memory], stop=memory.has_ended)
    finally:
        tracemalloc.stop()
    assert memory.has_ended()
    before, after = np.median(memory.sizes[:3]), np.median(memory.sizes[-3:])
    assert after - before < SENT / 2
