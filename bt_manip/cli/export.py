"""``bt-manip export``: convert a recording."""

from pathlib import Path
from typing import Any

import click

from bt_manip.extras import require_extra

VIDEOS = ("mp4", "gif")
FORMATS = ("csv", "parquet", "mcap", "btlog", "db3", *VIDEOS)


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--to", "form", type=click.Choice(FORMATS), help="Format.  [default: the suffix of --out]"
)
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), metavar="OUT",
    help="File to write.  [default: FILE with the suffix of the format]",
)  # fmt: skip
@click.option("--camera", metavar="NAME", help="Of a video.  [default: overview]")
@click.option("--size", metavar="WxH", help="Of a video, in pixels.  [default: 640x400]")
@click.option("--fps", type=float, help="Frames per simulated second.  [default: 25]")
@click.option("--overlay", is_flag=True, help="Show time and running leaves over a video.")
def export(
    file: Path,
    form: str | None,
    out: Path | None,
    camera: str | None,
    size: str | None,
    fps: float | None,
    overlay: bool,
) -> None:
    """Convert a recording to a table, a complete recording, a log of Groot2, or a video.

    FILE is a recording of bt-manip run --record FILE.mcap; what can be read of a cut one is used.
    csv and parquet have a row for each control step; btlog and db3 open in Groot2.
    """
    form = form or (out.suffix[1:] if out is not None else "")
    if form not in FORMATS:
        raise click.UsageError(f"--to or the suffix of --out is one of {', '.join(FORMATS)}")
    options: dict[str, Any] = {
        "camera": camera,
        "size": size,
        "fps": fps,
        "overlay": overlay or None,
    }
    given = {name: value for name, value in options.items() if value is not None}
    if given and form not in VIDEOS:
        raise click.UsageError(f"--{next(iter(given))} is an option of {' and '.join(VIDEOS)}")
    if out is None:
        out = file.with_suffix(".complete.mcap" if form == "mcap" else f".{form}")
    packages = ["mcap", "foxglove_schemas_protobuf"]
    packages += ["av"] * (form in VIDEOS) + ["pyarrow"] * (form in ("csv", "parquet"))
    require_extra("record", "export", *packages)
    from bt_manip.viewer import use_offscreen_opengl

    use_offscreen_opengl()
    from bt_manip import recording as formats

    formats.check_writable(out, "export", source=None if form == "mcap" else file)
    recording = formats.Recording(file)
    if form in VIDEOS:
        formats.write_video(recording, out, **given)
    elif form in ("csv", "parquet", "mcap"):
        getattr(formats, f"write_{form}")(recording, out)
    else:
        from bt_manip.groot import BtlogRecorder, SqliteRecorder

        recorder = BtlogRecorder(out) if form == "btlog" else SqliteRecorder(out)
        recorder.write_recording(recording)
    click.echo(f"{out}: {out.stat().st_size / 1e6:.2f} MB")
