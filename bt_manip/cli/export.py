"""``bt-manip export``: convert a recording."""

import importlib
from pathlib import Path
from typing import NamedTuple

import click
from click.shell_completion import CompletionItem

from bt_manip.cli.completion import complete_part
from bt_manip.cli.plugin_options import load_chosen_plugins
from bt_manip.exceptions import require_extra
from bt_manip.packages import missing
from bt_manip.parameters import parameters_of


class ExportFormat(NamedTuple):
    """A format of ``bt-manip export``; its name is the suffix of its files.

    Attributes:
        write: Module and function, called with the recording and the path.
        packages: What it needs beside the packages of recordings.
    """

    write: str
    packages: tuple[str, ...] = ()


FORMATS = {
    "csv": ExportFormat("bt_manip.record:write_csv", ("pyarrow",)),
    "parquet": ExportFormat("bt_manip.record:write_parquet", ("pyarrow",)),
    "npz": ExportFormat("bt_manip.record:write_trace"),
    "mcap": ExportFormat("bt_manip.record:write_mcap"),
}
"""The built-in formats by name; a new one is a line here, or a plugin's."""


def _complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    others = complete_part("export_formats")(ctx, param, incomplete)
    items = [CompletionItem(name) for name in FORMATS if name.startswith(incomplete)]
    return items + [one for one in others if one.type != "file"]


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--to", "form", metavar="FORMAT", shell_complete=_complete,
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
    others = {} if form in FORMATS else load_chosen_plugins().parts.export_formats.copies()
    if form not in FORMATS and form not in others:
        known = f"--to or the suffix of --out is one of {', '.join([*FORMATS, *others])}"
        package = missing("export format", form)
        raise click.UsageError(f"{form} {package}" if package else known)
    chosen = FORMATS.get(form, ExportFormat(""))
    options = {"camera": camera, "size": size, "fps": fps, "overlay": overlay}
    given = {name: value for name, value in options.items() if value is not None}
    for name in given:
        if form not in others or name not in parameters_of(others[form], keyword_only=True):
            raise click.UsageError(f"--{name} is an option of mp4 and gif")
    if out is None:
        out = file.with_suffix(".complete.mcap" if form == "mcap" else f".{form}")
    require_extra("record", "export", "mcap", "foxglove_schemas_protobuf", *chosen.packages)
    from bt_manip.record import Recording, check_writable
    from bt_manip.viewer import use_offscreen_opengl

    use_offscreen_opengl()
    check_writable(out, "export", source=None if form == "mcap" else file)
    if form in others:
        write = others[form]
    else:
        module, _, function = chosen.write.partition(":")
        write = getattr(importlib.import_module(module), function)
    write(Recording(file), out, **given)
    click.echo(f"{out}: {out.stat().st_size / 1e6:.2f} MB")
