"""``bt-manip export``: convert a recording."""

import importlib
from pathlib import Path
from typing import NamedTuple

import click

from bt_manip.exceptions import require_extra


class ExportFormat(NamedTuple):
    """A format of ``bt-manip export``; its name is the suffix of its files.

    Attributes:
        write: Module and function, called with the recording, the path and the given options.
        packages: What it needs beside the packages of recordings.
        options: Its options.
    """

    write: str
    packages: tuple[str, ...] = ()
    options: tuple[str, ...] = ()


VIDEO_FORMAT = ExportFormat(
    "bt_manip.record:write_video", ("av",), ("camera", "size", "fps", "overlay")
)

FORMATS = {
    "csv": ExportFormat("bt_manip.record:write_csv", ("pyarrow",)),
    "parquet": ExportFormat("bt_manip.record:write_parquet", ("pyarrow",)),
    "npz": ExportFormat("bt_manip.record:write_trace"),
    "mcap": ExportFormat("bt_manip.record:write_mcap"),
    "btlog": ExportFormat("bt_manip.groot:write_btlog"),
    "db3": ExportFormat("bt_manip.groot:write_sqlite"),
    "mp4": VIDEO_FORMAT,
    "gif": VIDEO_FORMAT,
}
"""All formats by name; a new one is a line here."""


def _complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[str]:
    return [name for name in FORMATS if name.startswith(incomplete)]


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--to", "form", metavar="FORMAT", shell_complete=_complete,
    help=f"{', '.join(FORMATS)}.  [default: the suffix of --out]",
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
    """Convert a recording to a table, a trace, a complete recording, a log of Groot2, or a video.

    FILE is a recording of bt-manip run --record FILE.mcap; what can be read of a cut one is used.
    csv and parquet have a row for each control step; btlog and db3 open in Groot2.
    """
    form = form or (out.suffix[1:] if out is not None else "")
    if form not in FORMATS:
        raise click.UsageError(f"--to or the suffix of --out is one of {', '.join(FORMATS)}")
    chosen = FORMATS[form]
    options = {"camera": camera, "size": size, "fps": fps, "overlay": overlay}
    given = {name: value for name, value in options.items() if value is not None}
    for name in given:
        if name not in chosen.options:
            having = [other for other, one in FORMATS.items() if name in one.options]
            raise click.UsageError(f"--{name} is an option of {' and '.join(having)}")
    if out is None:
        out = file.with_suffix(".complete.mcap" if form == "mcap" else f".{form}")
    require_extra("record", "export", "mcap", "foxglove_schemas_protobuf", *chosen.packages)
    from bt_manip.record import Recording, check_writable
    from bt_manip.viewer import use_offscreen_opengl

    use_offscreen_opengl()
    check_writable(out, "export", source=None if form == "mcap" else file)
    module, _, function = chosen.write.partition(":")
    getattr(importlib.import_module(module), function)(Recording(file), out, **given)
    click.echo(f"{out}: {out.stat().st_size / 1e6:.2f} MB")
