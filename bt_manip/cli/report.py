"""``bt-manip report``: the report of a recorded run as an HTML file."""

import os
from pathlib import Path

import click

from bt_manip.extras import require_extra


@click.command()
@click.argument("recording", type=click.Path(path_type=Path), metavar="FILE.mcap")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), metavar="FILE.html",
    help="The file to write.  [default: beside the recording]",
)  # fmt: skip
def report(recording: Path, output: Path | None) -> None:
    """Write the report of a recorded run.

    It is one HTML file that any browser shows without a network: cycles, time line of the tree,
    plots, and the scene in 3D.
    """
    os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn here
    require_extra("record", "report", "mcap", "foxglove_schemas_protobuf")
    require_extra("view", "report", "bokeh", "viser")
    from bt_manip.recording import Recording, check_writable, whole_file, writing
    from bt_manip.viewer.report import html_report

    path = output or recording.with_suffix(".html")
    check_writable(path, "report", source=recording)
    page = html_report(Recording(recording)).encode()
    with writing(path, "report"), whole_file(path) as file:
        file.write(page)
    click.echo(f"Report: {path} ({len(page) / 1e6:.1f} MB)")
