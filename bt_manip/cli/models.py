"""``bt-manip models``: list, download and show models."""

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.completion import complete_model_caches
from bt_manip.cli.plugin_group import PluginGroup
from bt_manip.cli.plugin_options import load_chosen_plugins
from bt_manip.exceptions import BtManipError
from bt_manip.packages import suggestion
from bt_manip.registry import Parts

if TYPE_CHECKING:
    from bt_manip.cell.objects import ModelObject
    from bt_manip.models import FoundModel, ModelCache

BUNDLED = "bundled"
_PARTS = "bt_manip.models.parts"


@click.group(cls=PluginGroup)
def models() -> None:
    """List, download and show models."""
    os.environ.setdefault("MUJOCO_GL", "disable")


@models.command("list")
@click.argument("source", required=False, shell_complete=complete_model_caches)
def list_models(source: str | None) -> None:
    """List the addresses of the models that can be used without a network.

    SOURCE is bundled, menagerie, fuel or a cache of another plugin: only its models; for Menagerie
    also those that would be downloaded, marked '*'. The models of Fuel are listed at
    https://app.gazebosim.org.
    """
    from bt_manip.models import bundled_names

    caches = _caches()
    known = sorted([BUNDLED, *caches])
    if source is not None and source not in known:
        what = suggestion("model cache", source, known)
        raise BtManipError(f"there is no source '{source}' of local models{what}")
    for chosen in [source] if source else known:
        found: Iterable[str]
        if chosen == BUNDLED:
            found = (f"bundled:{name}" for name in bundled_names())
        else:
            found = caches[chosen].addresses(everything=source is not None)
        for line in found:
            click.echo(line)


@models.command()
@click.argument("addresses", nargs=-1, required=True, metavar="ADDRESS...")
def fetch(addresses: tuple[str, ...]) -> None:
    """Download models, or newer versions of those in the cache.

    ADDRESS is fuel:OWNER/NAME, fuel:OWNER/NAME/VERSION, the URL of a model on Fuel, or
    menagerie:NAME.
    """
    from bt_manip.models import find_model

    for address in addresses:
        cache = _cache_of(address)
        if cache is not None:
            found, path = cache.fetch(address)
            click.echo(f"{found}  {path}")
        else:
            model = find_model(address, **_parts_of(address))
            click.echo(f"{model.address}  {model.path}")


@models.command()
@click.argument("address")
def path(address: str) -> None:
    """Print the path of a model's file, downloading the model if needed."""
    from bt_manip.models import find_model

    click.echo(find_model(address, **_parts_of(address)).path)


@models.command()
@click.argument("address")
@click.option("--mjcf", is_flag=True, help="Print the model as MJCF instead.")
def show(address: str, mjcf: bool) -> None:
    """Print a model's file, parts, mass and size, and what was lost in its conversion."""
    from bt_manip.cell.objects import ModelObject
    from bt_manip.models import find_model, load_model

    model = load_model(address, **_parts_of(address))
    if mjcf:
        click.echo(model.xml or (model.path.read_text("utf-8") if model.path else ""))
        return
    thing = ModelObject(model)
    for key, value in _facts(thing, find_model(address, **_parts_of(address))):
        click.echo(f"{key:10}  {value}")
    for warning in thing.warnings:
        click.echo(f"Warning: {warning}", err=True)


@models.command()
@click.argument("addresses", nargs=-1, metavar="[ADDRESS]...")
@click.option("--all", "everything", is_flag=True, help="All downloaded models.")
@click.option("--yes", is_flag=True, help="Do not ask.")
def clear(addresses: tuple[str, ...], everything: bool, yes: bool) -> None:
    """Delete downloaded models: fuel:OWNER/NAME with or without a version, menagerie:NAME.

    The cache of Fuel is shared with Gazebo: models deleted here are deleted there.
    """
    if bool(addresses) == everything:
        raise click.UsageError("give the addresses of the models to delete, or --all")
    if everything and not yes:
        click.confirm("Delete all downloaded models, Gazebo's too?", abort=True)
    gone = [p for text in addresses for p in _clear(text)]
    if everything:
        gone = [p for cache in _caches().values() for p in cache.clear()]
    for folder in gone:
        click.echo(f"deleted {folder}")
    if not gone:
        click.echo("nothing to delete")


def _facts(thing: "ModelObject", found: "FoundModel") -> Iterator[tuple[str, str]]:
    root = thing.mjcf_model
    yield "address", thing.kind
    yield "file", str(found.path)
    yield "format", found.format
    for kind in ("body", "joint", "geom"):
        names = [element.name for element in root.find_all(kind)]
        shown = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
        yield kind, f"{len(names)}" + (f": {shown}" if names and kind != "geom" else "")
    edges = thing.bounds.size.tolist()
    size = " x ".join(max(f"{edge:.3f}", f"{edge:.4g}", key=len) for edge in edges)
    yield "mass", f"{thing.mass:.4g} kg"
    yield "size", f"{size} m"
    yield "moves", "freely" if thing.free else "not"
    yield "category", thing.category


def _clear(address: str) -> list[Path]:
    cache = _cache_of(address)
    if cache is None:
        from bt_manip.models import check_package

        check_package(address, "model source", address.partition(":")[0])
        kinds = " and ".join(f"{name}:" for name in _caches())
        raise BtManipError(f"'{address}': only models of {kinds} are downloaded")
    return cache.remove(address)


def _caches() -> dict[str, "ModelCache"]:
    caches = _parts().model_caches
    return {name: caches.create(name) for name in caches}


def _cache_of(address: str) -> "ModelCache | None":
    """Return the cache that has the models of an address, if any."""
    kind = address.partition(":")[0].lower() if ":" in address else ""
    return next((cache for cache in _caches().values() if kind in cache.kinds), None)


def _parts_of(address: str) -> dict[str, Any]:
    """Return the arguments for `find_model`; models with built-in sources need no plugins."""
    if address.partition(":")[0].lower() in (BUNDLED, "menagerie"):
        return {}
    parts = _parts()
    return {"sources": parts.model_sources.copies(), "formats": parts.model_formats.copies()}


def _parts() -> Parts:
    """Return the parts of the chosen plugins, which are loaded once in a command."""
    meta = click.get_current_context().meta
    if _PARTS not in meta:
        meta[_PARTS] = load_chosen_plugins().parts
    return meta[_PARTS]
