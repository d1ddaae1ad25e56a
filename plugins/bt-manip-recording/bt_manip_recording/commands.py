"""``bt-manip export``: convert a recording."""

import inspect
from pathlib import Path

import click

from bt_manip.cli import complete_part, load_chosen_plugins
from bt_manip_recording.plugin import FORMATS


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--to", "form", metavar="FORMAT", shell_complete=complete_part("export_formats"),
    help=f"{', '.join(FORMATS)}, or a plugin's (see: bt-manip list export_formats).  [default: "
    "the suffix of --out]",
)  # fmt: skip
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), metavar="OUT",
    help="File to write.  [default: FILE with the suffix of the format]",
)  # fmt: skip
@click.option("--camera", metavar="NAME", help="Of a video.  [default: overview]")
@click.option("--size", metavar="WxH", help="Of a video, in pixels.  [default: 1280x720]")
@click.option("--fps", type=float, help="Frames per simulated second.  [default: 25]")
@click.option(
    "--overlay/--no-overlay", default=None,
    help="Show time and running leaves over a video.  [default: overlay]",
)  # fmt: skip
def export(
    file: Path,
    form: str | None,
    out: Path | None,
    camera: str | None,
    size: str | None,
    fps: float | None,
    overlay: bool | None,
) -> None:
    """Convert a recording to a table, a trace, a complete recording, or a video.

    FILE is a recording of bt-manip run --record FILE.mcap; what can be read of a cut one is used.
    csv and parquet have a row for each control step.
    """
    form = form or (out.suffix[1:] if out is not None else "")
    formats = load_chosen_plugins().parts.of("export_formats")
    if not form:
        known = ", ".join(dict.fromkeys([*FORMATS, *formats]))
        raise click.UsageError(f"--to or the suffix of --out is one of {known}")
    write = formats.get(form)
    options = {"camera": camera, "size": size, "fps": fps, "overlay": overlay}
    given = {name: value for name, value in options.items() if value is not None}
    for name in given:
        if name not in inspect.signature(write).parameters:
            raise click.UsageError(f"--{name} is an option of mp4 and gif")
    if out is None:
        out = file.with_suffix(".complete.mcap" if form == "mcap" else f".{form}")
    from bt_manip.record import check_writable
    from bt_manip.viewer import use_offscreen_opengl
    from bt_manip_recording.recording import Recording

    use_offscreen_opengl()
    check_writable(out, "export", source=None if form == "mcap" else file)
    write(Recording(file), out, **given)
    click.echo(f"{out}: {out.stat().st_size / 1e6:.2f} MB")
