"""Episodes of a tree: one run of its root from home, randomized by its number."""

import json
import os
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from bt_manip.exceptions import ANY_BUT_INTERRUPT, BtManipError, NodeError, reason_of
from bt_manip.plugins import load_plugins
from bt_manip.record import (
    CycleReport,
    Recorder,
    cpu_name,
    identify,
    identity_differences,
    versions,
)
from bt_manip.runner import EPISODE_TIMEOUT, NOT_MET, ParameterSet, Run, prepare, request_of

from .engine import WorkerDiedError

NO_OUTCOME = ("UNSTARTED", "DIED")
"""Statuses of episodes of which nothing is known but that they did not succeed."""


class EpisodeId(NamedTuple):
    """An episode of an evaluation.

    Attributes:
        point: Index of the values of the varied parameters.
        episode: Its number, from which samples and random generator follow.
    """

    point: int
    episode: int


@dataclass(frozen=True)
class Evaluation:
    """Specification of an evaluation; it can be pickled.

    Attributes:
        tree: The tree as the user names it.
        options: Fields of `bt_manip.runner.RunRequest`; ``seed`` is one of them.
        points: Values of the varied parameters, by name; one empty point if nothing varies.
        timeout: Simulated time after which an episode has failed [s].
        choice: The `bt_manip.plugins.PluginSelection`; None: that of the environment.
        identity: The `EpisodeWorker.identity` that all workers must have; None: any.
    """

    tree: str
    options: Mapping[str, Any] = field(default_factory=dict)
    points: tuple[ParameterSet, ...] = ({},)
    timeout: float = EPISODE_TIMEOUT
    choice: Any = None
    identity: Mapping[str, Any] | None = None

    @property
    def seed(self) -> int:
        """The seed of all episodes."""
        return int(self.options.get("seed") or 0)


@dataclass(frozen=True)
class EpisodeResult:
    """How an episode ended: a row of the table of results.

    Attributes:
        point: As in `EpisodeId`.
        episode: As there.
        seed: The seed.
        success: Whether the tree succeeded, and its goal held in the physics.
        status: ``"SUCCESS"``, ``"FAILURE"``, ``"TIMEOUT"``, ``"ERROR"`` if a behaviour or a
            plugin raised, ``"UNSTARTED"`` if the episode did not begin, or ``"DIED"`` if the
            process died again and again.
        reason: Why it did not succeed.
        node: Path of the node that failed; ``goal`` if the tree succeeded without its goal.
        goal: Whether the goal held; None if the tree declares none.
        duration_s: Simulated time that it took [s].
        wall_s: Wall time that it took [s].
        digest: SHA-256 over states and node statuses after every tick.
        randomized: The samples as JSON, by kind, name and quantity.
        leaf_times: `CycleReport.leaf_times` as JSON.
        drawn: `CycleReport.drawn` as JSON.
        retries: `CycleReport.retries` as JSON.
        rescues: `CycleReport.rescues` as JSON.
        results: `CycleReport.results` as JSON.
        cpu: Type of the CPU that it ran on.
        absent: Varied quantities of objects that were not in the cell, separated by spaces.
        missed: `RunModifier.missed` of all modifiers, in lines.
        files: SHA-256 of the files that were loaded besides those of the evaluation's identity, by
            name, as JSON.
    """

    point: int
    episode: int
    seed: int
    success: bool
    status: str
    reason: str = ""
    node: str = ""
    goal: bool | None = None
    duration_s: float = 0.0
    wall_s: float = 0.0
    digest: str = ""
    randomized: str = "{}"
    leaf_times: str = "{}"
    drawn: str = "{}"
    retries: str = "{}"
    rescues: str = "{}"
    results: str = "{}"
    cpu: str = ""
    absent: str = ""
    missed: str = ""
    files: str = "{}"


class EpisodeWorker:
    """Runs episodes in one station, which returns to its initial state for each.

    Attributes:
        evaluation: The evaluation.
        identity: What the results depend on besides the episode, as plain data.
        warnings: Warnings of the checks of the tree's document.

    Raises:
        BtManipError: If the request is invalid, or this machine has other versions or files.
    """

    def __init__(self, evaluation: Evaluation) -> None:
        os.environ.setdefault("MUJOCO_GL", "disable")
        self.evaluation = evaluation
        self._parts = load_plugins(choice=evaluation.choice, warn=lambda message: None).parts
        self._request = request_of(evaluation.tree, self._parts, **evaluation.options)
        self._point = 0
        self._run = self._prepare(0)
        self.warnings = self._run.tree.warnings
        self.identity = self._identify()
        if evaluation.identity is not None:
            refuse_difference("a worker", self.identity, evaluation.identity)

    def run(self, episode: EpisodeId) -> EpisodeResult:
        """Run an episode; an exception in the tree fails the episode."""
        if episode.point != self._point:
            self._run, self._point = self._prepare(episode.point), episode.point
        run, start = self._run, time.perf_counter()
        run.begin_episode(episode.episode)
        recorder = Recorder(self.evaluation.tree, run.request.seed)
        end = run.station.cell.time + self.evaluation.timeout
        status, reason, node = "", "", ""
        try:
            run.execute([recorder], stop=lambda: run.station.cell.time > end)
        except ANY_BUT_INTERRUPT as error:
            status = "ERROR" if recorder.began else "UNSTARTED"
            reason = reason_of(error)
            if isinstance(error, NodeError):
                node = error.path
        report = recorder.report(status or "TIMEOUT")
        cycle = report.cycles[-1] if report.cycles else CycleReport(status)
        if cycle.status == "TIMEOUT":
            node = ", ".join(one.name for one in cycle.phases if one.status == "HALTED")
            reason = f"no end within {self.evaluation.timeout:g} s simulated"
        elif cycle.status == "FAILURE" and cycle.reason.startswith(NOT_MET):
            node, reason = "goal", cycle.goal_reason
        elif cycle.status == "FAILURE":
            node, _, reason = cycle.reason.partition(": ")
        return EpisodeResult(
            *episode,
            seed=run.request.seed,
            success=cycle.status == "SUCCESS",
            status=cycle.status,
            reason=reason,
            node=node,
            goal=cycle.goal,
            duration_s=cycle.duration_s,
            wall_s=time.perf_counter() - start,
            digest=report.state_digest,
            randomized=json.dumps(cycle.randomized),
            leaf_times=json.dumps({name: vars(one) for name, one in cycle.leaf_times.items()}),
            drawn=json.dumps(cycle.drawn),
            retries=json.dumps(cycle.retries),
            rescues=json.dumps(cycle.rescues),
            results=json.dumps(cycle.results),
            cpu=cpu_name(),
            absent=" ".join(run.absent),
            missed="\n".join(text for modifier in run.modifiers for text in modifier.missed),
            files=json.dumps(dict(other_files(run.all_files, self.identity))),
        )

    def _prepare(self, point: int) -> Run:
        varied = self.evaluation.points[point]
        return prepare(replace(self._request, varied=varied), self._parts)

    def _identify(self) -> dict[str, Any]:
        evaluation = self.evaluation
        found = {
            "tree": evaluation.tree,
            "seed": evaluation.seed,
            "timeout": evaluation.timeout,
            "points": [dict(point) for point in evaluation.points],
            **identify(replace(self._run, request=self._request)),
            "versions": versions(),
        }
        return json.loads(json.dumps(found))


def lost_episode(seed: int, episode: EpisodeId, error: WorkerDiedError) -> EpisodeResult:
    """Return the result of an episode whose processes died."""
    return EpisodeResult(*episode, seed, False, "DIED", str(error), cpu=cpu_name())


def other_files(
    files: Mapping[str, str], identity: Mapping[str, Any] | None
) -> Iterator[tuple[str, str]]:
    """Yield name and SHA-256 of files that are not those of an identity."""
    known = (identity or {}).get("sha256", {})
    return ((name, digest) for name, digest in files.items() if known.get(name) != digest)


def refuse_difference(what: str, found: Mapping[str, Any], expected: Mapping[str, Any]) -> None:
    """Raise a `BtManipError` where two identities differ; `what` belongs to the first."""
    differences = list(identity_differences(found, expected).values())
    if differences:
        raise BtManipError(f"{what} is of another evaluation: {'; '.join(differences[:5])}")
