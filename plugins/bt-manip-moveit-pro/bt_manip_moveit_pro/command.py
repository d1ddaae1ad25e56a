"""``bt-manip objectives``."""

from pathlib import Path

import click

from bt_manip.cli import FAILED, SUCCESS


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--run", "runs", is_flag=True, help="Run those that have all leaves.")
@click.option("--only", default="", metavar="TEXT", help="Only objectives with this in their path.")
def objectives(folder: Path, runs: bool, only: str) -> int:
    """Print which objectives of a workspace of MoveIt Pro have all leaves, and run.

    FOLDER is the workspace, or a part of it. Each objective is read with the trees of all, and runs
    on the UR5e, Gen3 or Panda that its waypoints fit, alone in a cell; an endless loop is stopped
    after two rounds.
    """
    from bt_manip.plugins import load_plugins
    from bt_manip_moveit_pro.objectives import HEADER, Workspace, summary, survey, table_row

    workspace = Workspace(folder.resolve(), load_plugins().parts)
    results = []
    click.echo(HEADER)
    for result in survey(workspace, run=runs, only=only):
        click.echo(table_row(result))
        results.append(result)
    click.echo(f"\n{summary(results)}")
    return FAILED if any(result.lacks for result in results) else SUCCESS
