"""Evaluate a tree: episodes in parallel, as many as are needed."""

import json
from collections.abc import Generator, Iterator
from functools import partial

from bt_manip.exceptions import BtManipError

from .engine import Pool, run_episodes
from .episode import EpisodeId, EpisodeResult, EpisodeWorker, Evaluation, lost_episode
from .success import SuccessRate

MIN_EPISODES = 30
"""Least number of episodes of a point before its interval can end it early: narrower ones are
due to chance when a rate is near 0 or 1."""


def evaluate(
    evaluation: Evaluation,
    episodes: int,
    workers: int = 1,
    *,
    pool: Pool | None = None,
    before: tuple[EpisodeResult, ...] | list[EpisodeResult] = (),
    until_width: float = 0.0,
) -> Generator[EpisodeResult]:
    """Run episodes 0 to n - 1 of each point, and yield their results as they end.

    Args:
        evaluation: The evaluation.
        episodes: Number of episodes of each point.
        workers: Number of workers.
        pool: Starts them, as for `run_episodes`.
        before: Results that are known, which are neither run nor yielded.
        until_width: Ends a point once the Wilson interval of its success rate is at most this
            wide; 0: never.

    Raises:
        BtManipError: If an episode has loaded another file than the evaluation or other episodes.
    """
    rates = [SuccessRate() for _ in evaluation.points]
    for result in before:
        rates[result.point].add(result)
    done = {EpisodeId(one.point, one.episode) for one in before}

    def wanted() -> Iterator[EpisodeId]:
        for point, rate in enumerate(rates):
            for episode in range(episodes):
                if rate.trials >= MIN_EPISODES and rate.interval.width <= until_width:
                    break
                if (point, episode) not in done:
                    yield EpisodeId(point, episode)

    files = dict((evaluation.identity or {}).get("sha256", {}))

    def check(result: EpisodeResult) -> None:
        for name, digest in json.loads(result.files).items():
            if files.setdefault(name, digest) != digest:
                raise BtManipError(
                    f"{name} differs between the episodes: SHA-256 {digest[:8]} in episode "
                    f"{result.episode}, {files[name][:8]} before"
                )

    for result in before:
        check(result)
    make = partial(EpisodeWorker, evaluation)
    lost = partial(lost_episode, evaluation.seed)
    for result in run_episodes(make, wanted(), workers, pool=pool, lost=lost):
        check(result)
        rates[result.point].add(result)
        yield result
