"""Parsing of untrusted XML, and checks of its numbers."""

import math
import re
from functools import partial
from pathlib import Path

from lxml import etree

from bt_manip.files import MAX_BYTES, read_bytes
from bt_manip.models.errors import ModelError

MAX_MODEL_ELEMENTS = 2_000  # of a model; PyMJCF takes a millisecond for each
MAX_ATTRIBUTES = 1_000  # of an element
LARGEST = 1e10  # mass [kg], density [kg/m^3] and moment of inertia [kg m^2]
MAX_GENERATED = {"flexcomp": 2**16, "hfield": 2**24, "texture": 2**26}  # which MuJoCo generates
_GENERATORS = ("replicate", "composite")  # of elements
_COUNTS = ("count", "nrow", "ncol", "width", "height")
_KG, _MOMENT = "[kg]", "[kg m^2]"
_MJCF = {"mass": _KG, "density": "[kg/m^3]", "diaginertia": _MOMENT}
_URDF = {"mass": {"value": _KG}, "inertia": dict.fromkeys(("ixx", "iyy", "izz"), _MOMENT)}
_UNDECLARED = etree.ErrorTypes.NS_ERR_UNDEFINED_NAMESPACE
_VERSION = re.compile(rb"\s*<\?xml\s+version\s*=\s*([\"'])[^\"'>]*")


def parse_xml(data: bytes, path: Path) -> etree._Element:
    """Parse the document of a file; document types, and so entities, are refused.

    As in other readers of models, any version of XML is read as 1.0, also after blank lines, and
    prefixes such as ``gazebo:`` need no namespace.

    Raises:
        ModelError: If it is not XML, too large, or has a document type.
    """
    if len(data) > MAX_BYTES:
        raise ModelError(f"{path}: longer than {MAX_BYTES // 2**20} MB")
    parsers = partial(
        etree.XMLParser, resolve_entities=False, no_network=True, load_dtd=False,
        dtd_validation=False, huge_tree=False, remove_comments=True, remove_pis=True,
    )  # fmt: skip
    if version := _VERSION.match(data):
        data = b"<?xml version=%s1.0" % version[1] + data[version.end() :]
    try:
        root = etree.fromstring(data, parser := parsers())
    except etree.XMLSyntaxError:
        for entry in (entry for entry in parser.error_log if entry.type != _UNDECLARED):
            where = f"{path}:{entry.line}:{entry.column}"
            raise ModelError(f"{where}: not XML: {entry.message}") from None
        root = etree.fromstring(data, parsers(recover=True))
    if root.getroottree().docinfo.doctype:
        raise ModelError(f"{path}: a document type (DOCTYPE) is not allowed in a model")
    return root


def read_xml(path: Path) -> etree._Element:
    """Read and parse the file of a model with `parse_xml`.

    Raises:
        ModelError: If it cannot be read, is not such a document, or has too many elements or
            attributes; for xacro, the message has the command that expands it.
    """
    try:
        data = read_bytes(path)
    except OSError as error:
        raise ModelError(f"{path}: cannot be read: {error.strerror}") from None
    root = parse_xml(data, path)
    number = 0.0
    for element in root.iter():
        where = f"{path}:{element.sourceline}"
        generators = (one for one in (element, *element.iterancestors()) if one.tag in _GENERATORS)
        number += math.prod(map(_count, generators))
        if number > MAX_MODEL_ELEMENTS:
            raise ModelError(f"{where}: more than {MAX_MODEL_ELEMENTS} elements")
        if (most := MAX_GENERATED.get(element.tag)) and _count(element) > most:
            raise ModelError(f"{where}: <{element.tag}> has more than {most} points")
        if len(element.attrib) > MAX_ATTRIBUTES:
            raise ModelError(f"{where}: <{element.tag}> has more than {MAX_ATTRIBUTES} attributes")
        values = element.attrib.values()
        if "/xacro" in f"/{element.tag}" or any("${" in text or "$(" in text for text in values):
            plain = Path(path.name.removesuffix(".xacro"))
            raise ModelError(
                f"{where}: this is xacro: expand it first, 'xacrodoc "
                f"{path.name} -o {plain.stem}.expanded{plain.suffix or '.urdf'}' "
                "(pip install xacrodoc; with ROS, xacro does the same)"
            )
    return root


def _count(element: etree._Element) -> float:
    """Return how many copies, points or pixels MuJoCo generates for an element."""
    text = " ".join(element.get(key, "") for key in _COUNTS)
    return math.prod(map(float, re.findall(r"\d+", text)))


def check_numbers(path: Path, element: etree._Element, *, urdf: bool = False) -> None:
    """Check the numbers of an element of MJCF or URDF, and the bounds of its inertia.

    Masses and the like may be zero here: bodies that do not move may have no mass.

    Raises:
        ModelError: If one is NaN, or if a mass, density or moment of inertia is negative, too large
            or not finite; with file and line.
    """
    where = f"{path}:{element.sourceline}: <{element.tag}>:"
    units = _URDF.get(str(element.tag), {}) if urdf else _MJCF
    for key, text in element.attrib.items():
        if key in units:
            try:
                values = [float(word) for word in text.split()]
            except ValueError:
                continue  # MuJoCo reports it
            if not all(0.0 <= value <= LARGEST for value in values):
                raise ModelError(
                    f"{where} {key} must be at least 0 and at most {LARGEST:g} {units[key]}, "
                    f"got {text}"
                )
        if key not in ("name", "class") and "nan" in text.lower().split():
            raise ModelError(f"{where} {key} has NaN, expected finite numbers")
