"""``bt-manip models``: list, download and show models."""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from bt_manip.cli.plugin_options import load_chosen_plugins
from bt_manip.exceptions import BtManipError

if TYPE_CHECKING:
    from bt_manip.models import MjcfModel, Source

SOURCES = ("bundled", "fuel", "menagerie")


@click.group()
def models() -> None:
    """List, download and show models."""
    os.environ.setdefault("MUJOCO_GL", "disable")


@models.command("list")
@click.argument("source", required=False, type=click.Choice(SOURCES))
def list_models(source: str | None) -> None:
    """List the addresses of the models that can be used without a network.

    With a source, only its models; for Menagerie also those that would be downloaded, marked '*'.
    The models of Fuel are listed at https://app.gazebosim.org.
    """
    for chosen in [source] if source else SOURCES:
        for line in _known(chosen, everything=source is not None):
            click.echo(line)


@models.command()
@click.argument("addresses", nargs=-1, required=True, metavar="ADDRESS...")
def fetch(addresses: tuple[str, ...]) -> None:
    """Download models, or newer versions of those in the cache.

    ADDRESS is fuel:OWNER/NAME, fuel:OWNER/NAME/VERSION, the URL of a model on Fuel, or
    menagerie:NAME.
    """
    from bt_manip.models import find_model
    from bt_manip.models.fuel import FuelClient, fuel_address

    for address in addresses:
        if address.startswith(("fuel:", "http:", "https:")):
            found, path = FuelClient().fetch(fuel_address(address))
            click.echo(f"{found}  {path}")
        else:
            model = find_model(address, sources=_sources(address))
            click.echo(f"{model.address}  {model.path}")


@models.command()
@click.argument("address")
def path(address: str) -> None:
    """Print the path of a model's file, downloading the model if needed."""
    from bt_manip.models import find_model

    click.echo(find_model(address, sources=_sources(address)).path)


@models.command()
@click.argument("address")
@click.option("--mjcf", is_flag=True, help="Print the model as MJCF instead.")
def show(address: str, mjcf: bool) -> None:
    """Print a model's file, parts, mass and size, and what was lost in its conversion."""
    from bt_manip.models import load_model

    model = load_model(address, sources=_sources(address))
    if mjcf:
        click.echo(model.xml or (model.path.read_text("utf-8") if model.path else ""))
        return
    for key, value in _facts(model, address):
        click.echo(f"{key:10}  {value}")
    for warning in model.warnings:
        click.echo(f"Warning: {warning}", err=True)


@models.command()
@click.argument("addresses", nargs=-1, metavar="[ADDRESS]...")
@click.option("--all", "everything", is_flag=True, help="All models of Fuel and Menagerie.")
@click.option("--yes", is_flag=True, help="Do not ask.")
def clear(addresses: tuple[str, ...], everything: bool, yes: bool) -> None:
    """Delete downloaded models: fuel:OWNER/NAME with or without a version, menagerie:NAME.

    The cache of Fuel is shared with Gazebo: models deleted here are deleted there.
    """
    if bool(addresses) == everything:
        raise click.UsageError("give the addresses of the models to delete, or --all")
    if everything and not yes:
        click.confirm("Delete all downloaded models, Gazebo's too?", abort=True)
    gone = _clear_all() if everything else [p for text in addresses for p in _clear(text)]
    for folder in gone:
        click.echo(f"deleted {folder}")
    if not gone:
        click.echo("nothing to delete")


def _known(source: str, everything: bool) -> Iterator[str]:
    if source == "bundled":
        from bt_manip.models import bundled_names

        yield from (f"bundled:{name}" for name in bundled_names())
    elif source == "fuel":
        from bt_manip.models.fuel import FuelCache

        yield from map(str, FuelCache().models())
    else:
        from bt_manip.models import is_cached, menagerie_names

        for name in menagerie_names():
            here = is_cached(name)
            if here or everything:
                yield f"menagerie:{name}" + ("" if here else " *")


def _facts(model: "MjcfModel", address: str) -> Iterator[tuple[str, str]]:
    from bt_manip.cell.objects import ModelObject
    from bt_manip.models import find_model

    thing = ModelObject(model)
    found = find_model(address, sources=_sources(address))
    root = thing.mjcf_model
    yield "address", model.address
    yield "file", str(found.path)
    yield "format", found.format
    for kind in ("body", "joint", "geom"):
        names = [element.name for element in root.find_all(kind)]
        shown = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
        yield kind, f"{len(names)}" + (f": {shown}" if names and kind != "geom" else "")
    size = " x ".join(f"{edge:.3f}" for edge in thing.bounds.size)
    yield "mass", f"{thing.mass:.4g} kg"
    yield "size", f"{size} m"
    yield "moves", "freely" if thing.free else "not"
    yield "category", thing.category


def _clear(address: str) -> list["Path"]:
    if address.startswith(("fuel:", "http:", "https:")):
        from bt_manip.models.fuel import FuelCache, fuel_address

        return FuelCache().remove(fuel_address(address))
    if address.startswith("menagerie:"):
        from bt_manip.models import remove

        return remove(address.removeprefix("menagerie:"))
    raise BtManipError(f"'{address}': only models of fuel: and menagerie: are downloaded")


def _clear_all() -> list["Path"]:
    from bt_manip.models import menagerie_names, remove
    from bt_manip.models.fuel import FuelCache

    cache = FuelCache()
    gone = [path for address in list(cache.models()) for path in cache.remove(address)]
    return gone + [path for name in menagerie_names() for path in remove(name)]


def _sources(address: str) -> "Mapping[str, Source]":
    """Return the sources of models; plugins are loaded only for addresses of unknown kinds."""
    from bt_manip.models import built_in_sources

    known = built_in_sources()
    kind, colon, _ = address.partition(":")
    if not colon or kind.lower() in (*known, "file") or Path(address).exists():
        return known
    sources = load_chosen_plugins().parts.model_sources
    return {kind: sources.get(kind) for kind in sources}
