"""``bt-manip mcp``: let an assistant check, run and repair trees."""

from pathlib import Path

import click

from bt_manip.cli import chosen, exit_code_help
from bt_manip_mcp.limits import Limits


@click.command(epilog=exit_code_help({0: "the client has closed the connection"}))
@click.option(
    "--folder", type=click.Path(exists=True, file_okay=False, path_type=Path), default=".",
    metavar="DIR", help="Where files are read and written.  [default: the current folder]",
)  # fmt: skip
@click.option(
    "--max-seconds", type=click.FloatRange(min=0.0, min_open=True), default=120.0,
    show_default=True, metavar="S", help="Wall time after which a request is stopped [s].",
)  # fmt: skip
@click.option(
    "--max-episodes", type=click.IntRange(min=1), default=100, show_default=True, metavar="N",
    help="Most cycles of a run, episodes of an evaluation, and seeds of a stress test.",
)  # fmt: skip
@click.option(
    "--allow-python", is_flag=True,
    help="Also run trees that are Python code of the folder. Without it no code there is loaded.",
)  # fmt: skip
def mcp(folder: Path, max_seconds: float, max_episodes: int, allow_python: bool) -> int:
    """Serve an assistant over standard input and output, by the Model Context Protocol.

    The client starts this command. It listens on no network.
    """
    from bt_manip_mcp.server import serve

    choice = chosen()
    serve(
        Limits(
            folder.resolve(), max_seconds, max_episodes, allow_python,
            tuple(choice.blocked), tuple(path.resolve() for path in map(Path, choice.folders)),
        )
    )  # fmt: skip
    return 0
