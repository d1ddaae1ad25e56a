"""``bt-manip report``: the page of a recorded run or an evaluation, or a report's cycles."""

import os
from pathlib import Path

import click


@click.command()
@click.argument("recording", type=click.Path(path_type=Path), metavar="FILE|DIR")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), metavar="FILE.html",
    help="The file to write.  [default: beside the recording]",
)  # fmt: skip
@click.option(
    "--map", "axes", nargs=2, metavar="X Y",
    help="Quantities of the map of an evaluation, named as its plots.  [default: the first two]",
)  # fmt: skip
def report(recording: Path, output: Path | None, axes: tuple[str, str] | None) -> None:
    """Write the page of a recorded run, or of the folder of an evaluation or a sweep.

    FILE.mcap is a recording. FILE.json or FILE.jsonl is a report, whose cycles are printed.

    It is one HTML file that any browser shows without a network. Of a run: cycles, time line of the
    tree, plots, and the scene in 3D. Of an evaluation: success against each parameter that varied.
    """
    os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn here
    if recording.suffix in (".json", ".jsonl"):
        if output is not None:
            raise click.UsageError("-o belongs to recordings and folders; a report is printed")
        _print(recording)
        return
    from bt_manip.record import check_writable, whole_file, writing
    from bt_manip_recording import Recording

    path = output or recording.with_suffix(".html")
    check_writable(path, "page", source=recording)
    note = ""
    if recording.is_dir():
        from bt_manip.evaluation import read_results
        from bt_manip_view import results_page

        page = results_page(*read_results(recording), axes or ()).encode()
    elif axes:
        raise click.UsageError("--map belongs to the folder of an evaluation")
    else:
        recorded = Recording(recording)  # read before what draws pages is imported
        from bt_manip_view import run_page

        page = run_page(recorded).encode()
        if not recorded.complete:
            note = f"The recording ended without an end, at {recorded.end:.2f} s."
    with writing(path, "page"), whole_file(path) as file:
        file.write(page)
    if note:
        click.echo(note)
    click.echo(f"Page: {path} ({len(page) / 1e6:.1f} MB)")


def _print(path: Path) -> None:
    """Print the cycles of a report."""
    from rich.console import Console

    from bt_manip.cli import print_cycles
    from bt_manip.record import read_report
    from bt_manip.viewer import print_wrapped

    console, found = Console(), read_report(path)
    print_cycles(console, found)
    if found.error:
        print_wrapped(console, f"Error: {found.error}")
    elif found.status == "RUNNING":
        print_wrapped(console, "The run goes on.")
