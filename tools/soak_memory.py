"""Print the memory of an endless pick_place that is shown, recorded and watched by Groot2.

``python tools/soak_memory.py --minutes 30`` starts ``bt-manip run pick_place --view --groot
--record --report``, with the page in a headless Chromium (without one, it is fetched each second)
and a client that asks as Groot2 does. It prints the resident memory of the run once a minute, and
the slope of a line through the second half. The first half fills caches and the rings of the page.
"""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import urllib.request
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

REPOSITORY = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(REPOSITORY / "plugins" / "bt-manip-groot" / "tests"))

from client import Client, free_ports  # noqa: E402

CHROMIUM = (
    "--headless=new", "--no-sandbox", "--remote-debugging-port=0", "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
)  # fmt: skip


def memory_of(process: int) -> float:
    """Return the resident memory of a process [MB]."""
    status = Path(f"/proc/{process}/status").read_text()
    return int(re.findall(r"VmRSS:\s*(\d+)", status)[0]) / 1024


def watch(minutes: float, speed: str, folder: Path) -> np.ndarray:
    """Run, and return time [min], memory [MB] and ended cycles of each minute."""  # (n, 3)
    port, report = free_ports(), folder / "report.jsonl"
    command = [sys.executable, "-m", "bt_manip", "run", "pick_place", "--cycles", "0"]
    command += ["--real-time", speed, "--view", "--groot", "--groot-port", str(port)]
    command += ["--record", str(folder / "run.mcap"), "--report", str(report)]
    with (folder / "out.txt").open("wb") as out:
        run = subprocess.Popen(command, stdout=out, env={**os.environ, "PYTHONUNBUFFERED": "1"})
    browser, rows = None, []
    try:
        while not (shown := re.findall(r"http://\S+\d", (folder / "out.txt").read_text())):
            if run.poll() is not None:
                raise RuntimeError(f"the run ended with exit code {run.returncode}")
            time.sleep(0.1)
        url = shown[0]
        found = shutil.which("chromium")
        if found:
            options = [*CHROMIUM, f"--user-data-dir={folder / 'chromium'}"]
            browser = subprocess.Popen([found, *options, url], stderr=subprocess.DEVNULL)
        groot, start = Client(port), time.monotonic()
        print(url, "in Chromium" if found else "fetched")
        print("  min      MB  cycles", flush=True)
        while (now := (time.monotonic() - start) / 60) < minutes + 0.01:
            groot.statuses()
            if not found:
                urllib.request.urlopen(url, timeout=30).read()
            elif browser is not None and browser.poll() is not None:
                raise RuntimeError(f"Chromium ended with exit code {browser.returncode}")
            if now >= len(rows):
                cycles = max(0, report.read_bytes().count(b"\n") - 1) if report.exists() else 0
                rows.append((now, memory_of(run.pid), cycles))
                print("{:5.1f} {:7.1f} {:7d}".format(*rows[-1]), flush=True)
            time.sleep(1.0)
        groot.close()
    finally:
        if browser is not None:
            browser.kill()
        run.send_signal(signal.SIGINT)
        run.wait(60)
    return np.array(rows)


def main() -> None:
    """Print the table and the slope."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--real-time", default="1", help="as of bt-manip run; 0: as fast as it can")
    given = parser.parse_args()
    with TemporaryDirectory() as folder:
        rows = watch(given.minutes, given.real_time, Path(folder))
        recorded = (Path(folder) / "run.mcap").stat().st_size / 1e6
    half = rows[len(rows) // 2 :]
    slope, _ = np.polyfit(half[:, 0], half[:, 1], 1)
    print(f"{slope:+.2f} MB/min in the second half; {recorded:.0f} MB were recorded")


if __name__ == "__main__":
    main()
