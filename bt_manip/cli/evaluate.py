"""``bt-manip evaluate`` and ``bt-manip sweep``: success rates of a tree over many episodes."""

import json
import os
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.exit_codes import FAILED, INTERRUPTED, SUCCESS, exit_code_help
from bt_manip.cli.json_output import findings_of, json_option, print_json
from bt_manip.cli.options import (
    Function,
    StationOptions,
    takes,
    vary_option,
    workers_option,
)
from bt_manip.cli.plugin_options import chosen, load_chosen_plugins, print_warning
from bt_manip.cli.view_options import ModifiedCommand
from bt_manip.exceptions import require_extra

if TYPE_CHECKING:
    from bt_manip.cli.evaluation_view import EvaluationView
    from bt_manip.evaluation import EpisodeResult, EpisodeWorker, Evaluation

SHOWN = 10
"""Number of episodes in which only one of two fails that are listed with their commands."""

_EPILOG = exit_code_help({SUCCESS: "every episode succeeded", FAILED: "one did not"})

_OPTIONS: tuple[Callable[[Function], Function], ...] = (
    click.option(
        "--episodes", type=click.IntRange(min=1), default=100, show_default=True, metavar="N",
        help="Number of episodes, of each point of a sweep.",
    ),
    click.option(
        "--seed", type=click.IntRange(min=0), default=0, show_default=True, metavar="S",
        help="Seed of all episodes.",
    ),
    workers_option,
    click.option(
        "--to", "folder", type=click.Path(path_type=Path), metavar="DIR",
        help="Write one row an episode, as Parquet; continues what is there already.",
    ),
    click.option(
        "--until-interval", type=click.FloatRange(0.0, 1.0), default=0.0, metavar="WIDTH",
        help="Stop as soon as the 95 % interval of the success rate is at most this wide; "
        "that biases the rate slightly upwards.",
    ),
    click.option(
        "--timeout", type=click.FloatRange(min=0.0, min_open=True), metavar="S",
        default=120.0, show_default=True,
        help="Simulated time after which an episode has failed [s].",
    ),
    takes(StationOptions, name="station"),
    json_option,
)  # fmt: skip


class EvaluatingCommand(ModifiedCommand):
    """A command with the options of modifiers and pools of workers."""

    brings = ("modifiers", "pools")


def evaluation_options(command: Function) -> Function:
    """Add the options that ``evaluate`` and ``sweep`` share."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


@click.command(cls=EvaluatingCommand, epilog=_EPILOG)
@click.argument(
    "trees", nargs=-1, required=True, metavar="TREE [OTHER]", shell_complete=complete_part("trees")
)
@vary_option
@evaluation_options
def evaluate(trees: tuple[str, ...], varied: tuple[str, ...], **options: Any) -> int:
    """Measure how often TREE succeeds; compare it with OTHER on the same episodes.

    Each episode starts at home, randomized by seed and number of the episode alone: the same
    episode has the same states in any process, and bt-manip run --episode N repeats it.
    """
    if len(trees) > 2:
        raise click.UsageError(f"one tree is evaluated, or two are compared, got {len(trees)}")
    from bt_manip.evaluation import parse_point

    return _execute(trees, lambda: (parse_point(varied),), **options)


@click.command(cls=EvaluatingCommand, epilog=_EPILOG)
@click.argument("tree", shell_complete=complete_part("trees"))
@click.option(
    "--vary", "varied", multiple=True, required=True, metavar='"KEY=VALUE,VALUE,..."',
    help="Vary a parameter: a key of the tree; robot, controller, scene or planner; "
    "controller.kp, scene.objects.cube.mass, robot.gripper.max_force and the like. Also "
    "KEY=LOW..HIGH:COUNT. May be given more than once: the grid of all combinations is run.",
)  # fmt: skip
@click.option(
    "--samples", type=click.IntRange(min=1), metavar="N",
    help="Sample N points instead of a grid; KEY=LOW..HIGH is then enough.",
)  # fmt: skip
@evaluation_options
def sweep(tree: str, varied: tuple[str, ...], samples: int | None, **options: Any) -> int:
    """Measure how the success of TREE depends on parameters.

    All points run the same episodes; where they are two, these are compared.
    """

    def points() -> Any:
        from bt_manip.evaluation import grid, parse_parameter
        from bt_manip.evaluation import samples as sampled

        parameters = [parse_parameter(text) for text in varied]
        names = [one.name for one in parameters]
        for name in names:
            if names.count(name) > 1:
                raise click.UsageError(f"--vary gives '{name}' twice")
        return sampled(parameters, samples, options["seed"]) if samples else grid(parameters)

    return _execute((tree,), points, **options)


class _Measured(NamedTuple):
    evaluation: "Evaluation"
    view: "EvaluationView"
    results: "list[EpisodeResult]"
    interrupted: bool


def _execute(
    trees: Sequence[str],
    make_points: Callable[[], Any],
    *,
    seed: int,
    pools: Mapping[str, str],
    folder: Path | None,
    until_interval: float,
    timeout: float,
    modifiers: Mapping[str, tuple[str, ...]],
    station: StationOptions,
    as_json: bool,
    **how: Any,
) -> int:
    os.environ.setdefault("MUJOCO_GL", "disable")
    if folder is not None:
        require_extra("learn", "--to", "pyarrow")
    if until_interval and len(trees) > 1:
        raise click.UsageError(
            "--until-interval does not go with two trees: both need all episodes"
        )
    if len(pools) > 1:
        raise click.UsageError(f"episodes run on one of {', '.join(pools)}")
    from bt_manip.evaluation import EpisodeWorker, Evaluation

    parts = load_chosen_plugins().parts  # warns of broken ones
    options = {**station.request_fields, "seed": seed, "modifiers": modifiers}
    points = make_points()
    make_pool: Callable[..., Any] | None = None
    for name, address in pools.items():
        make_pool = partial(parts.pools.maker(name, "start", "wait", "close"), address=address)
    evaluations = [Evaluation(tree, options, points, timeout, chosen()) for tree in trees]
    workers = [EpisodeWorker(one) for one in evaluations]  # bad input is found here
    warnings = [warning for worker in workers for warning in worker.warnings]
    for warning in dict.fromkeys(warnings):
        print_warning(str(warning))
    measured: list[_Measured] = []
    for tree, evaluation, worker in zip(trees, evaluations, workers, strict=True):
        own = folder
        if len(trees) > 1:
            if not as_json:
                click.echo(f"{tree}:")
            own = folder and folder / "ab"[len(measured)]
        one = _measure(
            evaluation, worker, own, make_pool=make_pool, until_interval=until_interval, **how
        )
        measured.append(one)
        if not one.interrupted and (never := _never_happened(one.results)):
            problem = f"{never}: nothing was measured."
            if as_json:
                print_json([*warnings, *findings_of([problem])])
            else:
                click.echo(problem, err=True)
            return FAILED
        if not as_json:
            _advise(one, own, until_interval)
        if one.interrupted:
            break
    interrupted = measured[-1].interrupted
    sides = [
        (one.evaluation, point, [r for r in one.results if r.point == point])
        for one in measured
        for point in range(len(points))
    ]
    two = len(sides) == 2 and not interrupted
    compared = _compare(*sides, as_json=as_json) if two else {}
    if as_json:
        print_json(warnings, evaluations=[*map(_plain, measured)], comparison=compared or None)
    if interrupted:
        return INTERRUPTED
    rates = [one.view.total for one in measured]
    return FAILED if any(one.successes < one.trials for one in rates) else SUCCESS


def _plain(measured: _Measured) -> dict[str, Any]:
    """Return the results of an evaluation as types of JSON: those of each point, and episodes."""
    evaluation, view = measured.evaluation, measured.view
    points = [
        {
            "varied": dict(point),
            "episodes": rate.trials,
            "successes": rate.successes,
            "interval": list(rate.interval),
            "failures": [vars(failure) for failure in rate.failures()],
            "results": {one.key: one.mean for one in rate.results()},
        }
        for point, rate in zip(evaluation.points, view.rates, strict=True)
    ]
    episodes = [vars(one) for one in measured.results]
    return {
        "tree": evaluation.tree, "seed": evaluation.seed, "interrupted": measured.interrupted,
        "points": points, "episodes": episodes,
    }  # fmt: skip


def _measure(
    evaluation: "Evaluation",
    worker: "EpisodeWorker",
    folder: Path | None,
    *,
    episodes: int,
    workers: int | None,
    make_pool: Callable[..., Any] | None,
    until_interval: float,
) -> _Measured:
    from bt_manip.cli.evaluation_view import EvaluationView
    from bt_manip.evaluation import EpisodeWorker, ProcessPool
    from bt_manip.evaluation import evaluate as run_evaluation

    evaluation = replace(evaluation, identity=worker.identity)
    interrupted = False
    with ExitStack() as stack:
        known: list[EpisodeResult] = []
        results = None
        if folder is not None:
            from bt_manip.evaluation import ResultFolder  # which needs Parquet

            results = ResultFolder(folder, worker.identity, evaluation.points)
            known += results.results
            stack.enter_context(results)
        make = partial(EpisodeWorker, evaluation)
        pool = ProcessPool(make) if make_pool is None else make_pool(make, workers=workers or 0)
        workers = workers or pool.cpus
        view = stack.enter_context(EvaluationView(evaluation, episodes, workers, known))
        try:
            found = run_evaluation(
                evaluation, episodes, workers, pool=pool, before=[*known],
                until_width=until_interval,
            )  # fmt: skip
            for result in stack.enter_context(closing(found)):
                if results is not None:
                    results.add(result)
                known.append(result)
                view.add(result)
        except KeyboardInterrupt:
            interrupted = True
    return _Measured(evaluation, view, known, interrupted)


def _never_happened(results: "list[EpisodeResult]") -> str:
    """Return which varied objects or faults were in no episode; empty if all were in one."""
    alive = [one for one in results if one.status != "DIED"]
    if missed := _common(one.missed.splitlines() for one in alive):
        return f"no episode had the {' or the '.join(missed)}"
    names = _common(one.absent.split() for one in alive)
    things = dict.fromkeys(name.split(".", 2)[2].rpartition(".")[0] for name in names)
    shown = " or ".join(f"'{thing}'" for thing in things)
    return f"nothing named {shown} was in the cell ({', '.join(names)})" if names else ""


def _common(lists: "Iterable[list[str]]") -> list[str]:
    """Return the texts that all lists have."""
    sets = [set(texts) for texts in lists]
    return sorted(set.intersection(*sets)) if sets else []


def _compare(
    a: "tuple[Evaluation, int, list[EpisodeResult]]",
    b: "tuple[Evaluation, int, list[EpisodeResult]]",
    *,
    as_json: bool,
) -> dict[str, Any]:
    """Print how two success rates on the same episodes differ, and in which; or return it."""
    from bt_manip.evaluation import PairedTable, mcnemar_p_value, newcombe_interval

    table = PairedTable.of(a[2], b[2])
    if not table.trials:
        return {}
    (low, high), p_value = newcombe_interval(table), mcnemar_p_value(table)
    if as_json:
        names = ["both", "only_a", "only_b", "neither", "difference"]
        counts = {name: getattr(table, name) for name in names}
        return counts | {"interval": [low, high], "p_value": p_value}
    names = [
        ", ".join(f"{k}={v}" for k, v in evaluation.points[point].items()) or evaluation.tree
        for evaluation, point, _ in (a, b)
    ]
    click.echo(f"A: {names[0]}\nB: {names[1]}")
    click.echo(
        f"Of {table.trials} episodes, {table.both} succeeded with both, {table.only_a} with A "
        f"only, {table.only_b} with B only, {table.neither} with neither."
    )
    click.echo(
        f"B - A: {table.difference:+.1%} (95 %, Newcombe: {low:+.1%} to {high:+.1%}); "
        f"exact McNemar test: p = {p_value:.3g}"
    )
    for which, winner, (loser, point, results) in (("A", b, a), ("B", a, b)):
        won = {one.episode for one in winner[2] if one.success}
        lost = sorted(one.episode for one in results if not one.success and one.episode in won)
        if lost:
            click.echo(f"{which} alone failed in episodes {', '.join(map(str, lost))}")
        for episode in lost[:SHOWN]:
            click.echo(f"  {_command(loser, episode, dict(loser.points[point]))}")
        if len(lost) > SHOWN:
            click.echo("  ..., and so on with the other numbers after --episode")
    return {}


def _advise(measured: _Measured, folder: Path | None, until_interval: float) -> None:
    """Print the results, and what to look at next."""
    evaluation, view, _, interrupted = measured
    view.print()
    if until_interval:
        click.echo(
            "The number of episodes depended on the results (--until-interval), which biases rates "
            "slightly upwards, by up to 0.014; a fixed --episodes does not."
        )
    if interrupted and folder is not None:
        click.echo("The same command continues where it was interrupted.")
    failure = next(iter(view.total.failures()), None)
    if failure is not None:
        command = _command(evaluation, failure.first, view.point_of(failure))
        click.echo(f"Watch the most frequent failure: {command}")
    elif view.total.trials:
        low = view.total.interval.low
        click.echo(f"No episode failed: with 95 % confidence, the rate is above {low:.1%}.")
    if folder is not None:
        click.echo(f"Results: {folder}; draw them: bt-manip report {shlex.quote(str(folder))}")


def _command(evaluation: "Evaluation", episode: int, point: "dict[str, Any]") -> str:
    """Return the command that shows an episode."""
    given = {**evaluation.options}
    given.pop("reading", None)  # what --strict refuses was not evaluated
    modifiers = given.pop("modifiers", {})
    varied = {name: point.pop(name) for name in [*point] if "." in name}
    keys = given.pop("settings", {}) | {k: v for k, v in point.items() if k not in given}
    given |= {key: value for key, value in point.items() if key in given}
    words = ["bt-manip", "run", evaluation.tree]
    defaults = {"robot": "panda", "planner": "rrt_connect"}  # the seed: that of the scene
    for key, value in given.items():
        if value is not None and value != defaults.get(key):
            words += ["--" + key.replace("_", "-"), str(value)]
    for key, value in keys.items():
        words += ["--set", f"{key}={value}"]
    for name, texts in modifiers.items():
        words += [word for text in texts for word in (f"--{name.replace('_', '-')}", text)]
    for key, value in varied.items():
        words += ["--vary", f"{key}={json.dumps(value)}"]
    return shlex.join([*words, "--episode", str(episode), "--view"])
