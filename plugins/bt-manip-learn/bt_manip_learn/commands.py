"""``bt-manip demos``: record demonstrations of a tree, and export them."""

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from bt_manip.cli import (
    FAILED,
    SUCCESS,
    StationOptions,
    chosen,
    complete_part,
    exit_code_help,
    load_chosen_plugins,
    takes,
    vary_option,
    workers_option,
)

if TYPE_CHECKING:
    from bt_manip_learn.demonstrations import DemonstrationRecorder


class DemonstrationFormat(NamedTuple):
    """A format of ``bt-manip demos export``.

    Attributes:
        write: Function of `bt_manip_learn.demonstrations`, called with the demonstrations, the
            path and its options.
        options: Its options.
        folder: Whether it writes a folder, not a file.
    """

    write: str
    options: tuple[str, ...] = ()
    folder: bool = False


DEMONSTRATION_FORMATS = {
    "robomimic": DemonstrationFormat("write_robomimic", ("actions", "observations")),
    "parquet": DemonstrationFormat("write_demonstration_table", ("observations",)),
    "lerobot": DemonstrationFormat(
        "write_lerobot", ("actions", "observations", "python"), folder=True
    ),
    "minari": DemonstrationFormat("write_minari", ("actions", "observations"), folder=True),
}
"""All formats by name."""


class _RecordByDefault(click.Group):
    """A group whose command ``record`` needs no name: ``bt-manip demos TREE``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Add the name of the default command."""
        if args and args[0] not in (*self.commands, *self.get_help_option_names(ctx)):
            args = ["record", *args]
        return super().parse_args(ctx, args)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command; that of a tree is ``record``."""
        return self.commands.get(cmd_name, self.commands["record"])


@click.group(cls=_RecordByDefault)
def demos() -> None:
    """Record demonstrations of TREE for learning, and export them.

    bt-manip demos TREE is short for bt-manip demos record TREE.
    """


@demos.command(epilog=exit_code_help({SUCCESS: "every episode succeeded", FAILED: "one failed"}))
@click.argument("tree", shell_complete=complete_part("trees"))
@click.option(
    "--episodes", type=click.IntRange(min=1), default=10, show_default=True, metavar="N",
    help="Number of episodes, from 0.",
)  # fmt: skip
@click.option(
    "--to", "folder", type=click.Path(path_type=Path), required=True, metavar="DIR",
    help="Folder to write; episodes that it has are kept.",
)  # fmt: skip
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, metavar="S",
    help="Seed of all randomness.",
)  # fmt: skip
@vary_option
@click.option("--all", "failures", is_flag=True, help="Keep the steps of failed episodes too.")
@click.option(
    "--images", default="", metavar="CAMERA,CAMERA", help="Record images of these cameras."
)
@click.option("--size", default="128x128", show_default=True, metavar="WxH", help="Of the images.")
@workers_option
@takes(StationOptions)
def record(
    tree: str,
    episodes: int,
    folder: Path,
    failures: bool,
    images: str,
    size: str,
    workers: int | None,
    seed: int,
    varied: tuple[str, ...],
    options: StationOptions,
) -> int:
    """Record what the tree does in episodes with different starts.

    Each episode becomes a file in DIR, with observations, actions and the statuses of the nodes 20
    times a second. The same command continues after an interruption.
    """
    if images:
        from bt_manip.viewer import use_offscreen_opengl

        use_offscreen_opengl()
    else:
        os.environ.setdefault("MUJOCO_GL", "disable")
    from bt_manip.cell import parse_size
    from bt_manip.cli import run_tracked
    from bt_manip.evaluation import call_in_process, parse_point
    from bt_manip.record import RecordingError
    from bt_manip_learn.demonstrations import DemonstrationRecorder, DemonstrationStore

    load_chosen_plugins()  # warns of broken ones
    make_recorder = partial(
        DemonstrationRecorder,
        folder,
        tree,
        choice=chosen(),
        cameras=[name.strip() for name in images.split(",") if name.strip()],
        size=parse_size(size),
        failures=failures,
        seed=seed,
        vary=parse_point(varied),
        **options.request_fields,
    )
    identity = call_in_process("the first episode", partial(_identify, make_recorder))
    store = DemonstrationStore.create(folder, identity)
    with store.recording():
        left = sorted({*range(episodes)}.difference(store.episodes()))
        _, code = run_tracked("demos", make_recorder, left, workers, store.write_lost)
        outcomes = store.write_outcomes()
    missing = len({*left}.difference(one["episode"] for one in outcomes))
    if missing and not code:
        raise RecordingError(f"{missing} episodes in '{folder}' were deleted during the recording")
    failed = [one for one in outcomes if not one["success"]]
    for one in failed:
        click.echo(f"episode {one['episode']} failed: {one['reason']}")
    steps = sum(one["steps"] for one in outcomes)
    click.echo(
        f"{folder}: {len(outcomes) - len(failed)} of {len(outcomes)} succeeded, {steps} steps"
    )
    return code or (FAILED if failed else SUCCESS)


def _identify(make_recorder: "Callable[[], DemonstrationRecorder]") -> dict[str, Any]:
    return make_recorder().identity()


@demos.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--format", "form", type=click.Choice(DEMONSTRATION_FORMATS), required=True)
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), required=True, metavar="OUT",
    help=f"File to write; a folder for "
    f"{', '.join(name for name, one in DEMONSTRATION_FORMATS.items() if one.folder)}.",
)  # fmt: skip
@click.option(
    "--actions", default="joint_targets", show_default=True, metavar="KIND",
    help="Kind of actions; parquet has all kinds.",
)  # fmt: skip
@click.option(
    "--observations", type=click.Choice(["robot", "all"]), metavar="GROUP",
    help="robot: those that a robot can measure; all: also those that only a simulator knows.  "
    "[default: robot for lerobot if there are images, else all]",
)  # fmt: skip
@click.option(
    "--python", metavar="PYTHON", help="Python of an environment with lerobot, for lerobot."
)
def export(
    folder: Path,
    form: str,
    out: Path,
    actions: str,
    observations: str | None,
    python: str | None,
) -> None:
    """Export the demonstrations in DIR.

    robomimic is one HDF5 file for robomimic, parquet a table with a row for each step, lerobot a
    LeRobotDataset, which LeRobot itself writes, minari a dataset of Minari.
    """
    chosen_format = DEMONSTRATION_FORMATS[form]
    if (python is not None) != ("python" in chosen_format.options):
        raise click.UsageError("--python belongs to --format lerobot, which needs it")
    from bt_manip.record import check_writable
    from bt_manip_learn import demonstrations

    store = demonstrations.read_demonstrations(folder)
    if not chosen_format.folder:
        check_writable(out, "export")
    given = {"actions": actions, "observations": observations, "python": python}
    options = {name: given[name] for name in chosen_format.options if given[name] is not None}
    n = getattr(demonstrations, chosen_format.write)(store, out, **options)
    click.echo(f"{out}: {n} demonstrations")
