"""``bt-manip report``: the report of a recorded run or an evaluation as an HTML file."""

import os
from pathlib import Path

import click

from bt_manip.extras import require_extra


@click.command()
@click.argument("recording", type=click.Path(path_type=Path), metavar="FILE.mcap|DIR")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), metavar="FILE.html",
    help="The file to write.  [default: beside the recording]",
)  # fmt: skip
def report(recording: Path, output: Path | None) -> None:
    """Write the report of a recorded run, or of the folder of an evaluation or a sweep.

    It is one HTML file that any browser shows without a network. Of a run: cycles, time line of the
    tree, plots, and the scene in 3D. Of an evaluation: success against each parameter that varied.
    """
    os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn here
    require_extra("view", "report", "bokeh", "viser")
    from bt_manip.recording import Recording, check_writable, whole_file, writing

    path = output or recording.with_suffix(".html")
    check_writable(path, "report", source=recording)
    if recording.is_dir():
        require_extra("learn", "report", "pyarrow")
        from bt_manip.evaluation import read_results
        from bt_manip.viewer.report import success_report

        page = success_report(*read_results(recording)).encode()
    else:
        require_extra("record", "report", "mcap", "foxglove_schemas_protobuf")
        from bt_manip.viewer.report import html_report

        page = html_report(Recording(recording)).encode()
    with writing(path, "report"), whole_file(path) as file:
        file.write(page)
    click.echo(f"Report: {path} ({len(page) / 1e6:.1f} MB)")
