"""Episodes in processes, with their progress in a terminal."""

import os
from collections.abc import Callable, Sequence
from typing import Any

from rich.console import Console
from rich.progress import track

from bt_manip.cli.exit_codes import INTERRUPTED, SUCCESS
from bt_manip.evaluation import ProcessPool, run_episodes


def run_tracked(
    label: str,
    make_worker: Callable[[], Any],
    episodes: Sequence[Any],
    workers: int | None,
    lost: Callable[..., Any],
) -> tuple[list[Any], int]:
    """Run episodes in processes; return their results, and SUCCESS or INTERRUPTED.

    Args:
        label: Text beside the progress bar.
        make_worker: As of `run_episodes`.
        episodes: The episodes.
        workers: Number of processes; None: one for each core.
        lost: As of `run_episodes`.
    """
    console, pool = Console(stderr=True), ProcessPool(make_worker)
    workers = min(workers or os.cpu_count() or 1, len(episodes))
    done = run_episodes(make_worker, episodes, workers, pool=pool, lost=lost)
    results = []
    try:
        for result in track(
            done, label, len(episodes), console=console, transient=True,
            disable=not console.is_terminal,
        ):  # fmt: skip
            results.append(result)
    except KeyboardInterrupt:
        return results, INTERRUPTED
    return results, SUCCESS
