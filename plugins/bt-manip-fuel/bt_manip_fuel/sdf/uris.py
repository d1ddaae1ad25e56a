"""Resolution of URIs in SDF documents."""

from collections.abc import Callable
from pathlib import Path
from urllib.parse import unquote, urlsplit

from bt_manip.models import ModelError, find_package_file
from bt_manip_fuel.model_config import sdf_file
from bt_manip_fuel.sdf.reader import SdfDocument

FetchFuel = Callable[[str], Path]
"""Function that returns the folder of a model by its Fuel address."""


def find_file(uri: str, document: SdfDocument, fetch: FetchFuel) -> SdfDocument:
    """Return the file of a URI in a document.

    A downloaded document may refer only to files in its own folder and to models on Fuel.

    Args:
        uri: A relative path, ``model://``, ``package://``, ``file://``, or an address on Fuel.
        document: The document with the URI.
        fetch: Returns models of Fuel.

    Raises:
        ModelError: If there is no such file, or it is not allowed.
    """
    path, root = document
    scheme = urlsplit(uri).scheme.lower() if "://" in uri else ""
    if scheme in ("http", "https"):
        address, _, inside = uri.partition("/files/")
        folder = fetch(address)
        return _inside(uri, folder / unquote(inside), folder)
    if scheme in ("model", "package"):
        own, rest = _own_folder(uri, document)
        if own is not None:
            return _inside(uri, own / rest, root)
        if root is not None:
            raise ModelError(f"'{uri}': a model from the network may not name other folders")
        return SdfDocument(find_package_file(uri, path), None)
    if scheme not in ("", "file"):
        raise ModelError(f"'{uri}': unknown kind of address '{scheme}:'")
    named = Path(unquote(uri.removeprefix("file://")) if scheme else uri)
    return _inside(uri, path.parent / named, root)


def included_file(uri: str, document: SdfDocument, fetch: FetchFuel) -> SdfDocument:
    """Return the document of an ``<include>``: a file, or a model's folder.

    Raises:
        ModelError: If there is no such document.
    """
    found = find_file(uri, document, fetch)
    if found.path.is_dir():
        return SdfDocument(sdf_file(found.path), found.root)
    if not found.path.is_file():
        raise ModelError(f"'{uri}': there is no such file")
    return found


def _inside(uri: str, path: Path, root: Path | None) -> SdfDocument:
    if root is not None and not path.resolve().is_relative_to(root.resolve()):
        raise ModelError(f"'{uri}': leaves the model's folder")
    return SdfDocument(path, root)


def _own_folder(uri: str, document: SdfDocument) -> tuple[Path | None, str]:
    """Return the folder and the rest of a URI that refers to its own model.

    In the cache of Fuel the model's folder is named by the version; its parent folder has the
    model's name in lower case.
    """
    name, _, rest = unquote(uri.partition("://")[2]).partition("/")
    if ".." in Path(rest).parts:
        raise ModelError(f"'{uri}': leaves the model's folder")
    for folder in list(document.path.parents)[:4]:
        named = folder.parent if folder.name.isdigit() else folder
        if _plain(named.name) == _plain(name):
            return folder, rest
    return None, rest


def _plain(name: str) -> str:
    return name.lower().replace("_", " ")
