"""``bt-manip report``: the report of a recorded run as an HTML file."""

import os
from pathlib import Path

import click

from bt_manip.exceptions import BtManipError
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
    from bt_manip.recording import Recording, check_writable, whole_file
    from bt_manip.viewer.report import html_report

    path = output or recording.with_suffix(".html")
    if path.resolve() == recording.resolve():
        raise BtManipError(f"report '{path}' would replace the recording")
    check_writable(path, "report")
    page = html_report(Recording(recording)).encode()
    try:
        with whole_file(path) as file:
            file.write(page)
    except OSError as error:
        reason = error.strerror or error
        raise BtManipError(f"report '{path}' cannot be written: {reason}") from error
    click.echo(f"Report: {path} ({len(page) / 1e6:.1f} MB)")
