"""``bt-manip evaluate`` and ``bt-manip sweep``: success rates of a tree over many episodes."""

import os
import shlex
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.interrupt import INTERRUPTED
from bt_manip.cli.plugin_options import chosen, load_chosen_plugins
from bt_manip.cli.settings import parse_settings
from bt_manip.cli.station_options import Command, station_options, workers_option
from bt_manip.extras import require_extra

if TYPE_CHECKING:
    from bt_manip.cli.evaluation_view import EvaluationView
    from bt_manip.evaluation import EpisodeResult, Evaluation, Failure

FAILED = 1
"""Exit code when an episode did not succeed."""

_EPILOG = "Exit codes: 0 every episode succeeded, 1 one did not, 2 bad input, 130 interrupted."

_OPTIONS: tuple[Callable[[Command], Command], ...] = (
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
        "--ray", is_flag=False, flag_value="local", metavar="[ADDRESS]",
        help="Run on a Ray cluster, HOST:PORT; without an address, on a local one.",
    ),
    click.option(
        "--to", "folder", type=click.Path(path_type=Path), metavar="DIR",
        help="Write one row an episode, as Parquet; continues what is there already.",
    ),
    click.option(
        "--until-interval", type=click.FloatRange(0.0, 1.0), default=0.0, metavar="WIDTH",
        help="Stop as soon as the 95 % interval of the success rate is at most this wide.",
    ),
    click.option(
        "--timeout", type=click.FloatRange(min=0.0, min_open=True), metavar="S",
        default=120.0, show_default=True,
        help="Simulated time after which an episode has failed [s].",
    ),
    station_options,
)  # fmt: skip


def evaluation_options(command: Command) -> Command:
    """Add the options that ``evaluate`` and ``sweep`` share."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


@click.command(epilog=_EPILOG)
@click.argument("tree", shell_complete=complete_part("trees"))
@evaluation_options
def evaluate(tree: str, **options: Any) -> int:
    """Measure how often TREE succeeds.

    Each episode starts at home, randomized by seed and number of the episode alone: the same
    episode has the same states in any process, and bt-manip run --episode N repeats it.
    """
    return _execute(tree, lambda: ({},), **options)


@click.command(epilog=_EPILOG)
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

    All points run the same episodes.
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

    return _execute(tree, points, **options)


def _execute(
    tree: str,
    make_points: Callable[[], Any],
    *,
    episodes: int,
    seed: int,
    workers: int | None,
    ray: str | None,
    folder: Path | None,
    until_interval: float,
    timeout: float,
    settings: tuple[str, ...],
    **parts: Any,
) -> int:
    """Evaluate, show the progress and the results; return the exit code."""
    os.environ.setdefault("MUJOCO_GL", "disable")
    if folder is not None:
        require_extra("learn", "--to", "pyarrow")
    if ray is not None:
        require_extra("ray", "--ray", "ray")
    from functools import partial

    from bt_manip.cli.evaluation_view import EvaluationView
    from bt_manip.evaluation import EpisodeWorker, Evaluation, RayPool, ResultFolder
    from bt_manip.evaluation import evaluate as run_evaluation

    load_chosen_plugins()  # warns of broken ones
    options = {"settings": parse_settings(settings), "seed": seed, **parts}
    evaluation = Evaluation(tree, options, make_points(), timeout, chosen())
    worker = EpisodeWorker(evaluation)  # bad input is found here
    evaluation = replace(evaluation, identity=worker.identity)
    with ExitStack() as stack:
        before: list[EpisodeResult] = []
        results = None
        if folder is not None:
            results = ResultFolder(folder, worker.identity, evaluation.points)
            before = results.results
            stack.enter_context(results)
        pool = None
        if ray is not None:
            pool = RayPool(partial(EpisodeWorker, evaluation), ray, workers or 0)
        workers = workers or (pool.cpus if pool is not None else os.cpu_count() or 1)
        view = stack.enter_context(EvaluationView(evaluation, episodes, workers, before))
        code = 0
        try:
            found = run_evaluation(
                evaluation, episodes, workers, pool=pool, worker=worker, before=before,
                until_width=until_interval,
            )  # fmt: skip
            for result in stack.enter_context(closing(found)):
                if results is not None:
                    results.add(result)
                view.add(result)
        except KeyboardInterrupt:
            code = INTERRUPTED
    _advise(view, evaluation, folder, interrupted=bool(code))
    return code or (FAILED if view.total.successes < view.total.trials else 0)


def _advise(
    view: "EvaluationView", evaluation: "Evaluation", folder: Path | None, *, interrupted: bool
) -> None:
    """Print the results, and what to look at next."""
    view.print()
    if interrupted and folder is not None:
        click.echo("The same command continues where it was interrupted.")
    failure = next(iter(view.total.failures()), None)
    if failure is not None:
        if (command := _command(evaluation, failure, view.point_of(failure))) is not None:
            click.echo(f"Watch the most frequent failure: {command}")
    elif view.total.trials:
        low = view.total.interval.low
        click.echo(f"No episode failed: with 95 % confidence, the rate is above {low:.1%}.")
    if folder is not None:
        click.echo(f"Results: {folder}; draw them: bt-manip report {shlex.quote(str(folder))}")


def _command(evaluation: "Evaluation", failure: "Failure", point: "dict[str, Any]") -> str | None:
    """Return the command that shows a failure; None if `bt-manip run` has no such options."""
    if any("." in name for name in point):
        return None
    given = {**evaluation.options}
    keys = given.pop("settings", {}) | {k: v for k, v in point.items() if k not in given}
    given |= {key: value for key, value in point.items() if key in given}
    words = ["bt-manip", "run", evaluation.tree]
    defaults = {"robot": "panda", "planner": "rrt_connect"}  # the seed: that of the scene
    for key, value in given.items():
        if value is not None and value != defaults.get(key):
            words += [f"--{key}", str(value)]
    for key, value in keys.items():
        words += ["--set", f"{key}={value}"]
    return shlex.join([*words, "--episode", str(failure.first), "--view"])
