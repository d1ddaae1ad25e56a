"""Parsing of untrusted XML."""

from pathlib import Path

from lxml import etree

from bt_manip.files import MAX_BYTES, read_bytes
from bt_manip.models.errors import ModelError


def parse_xml(data: bytes, path: Path) -> etree._Element:
    """Parse a document; document types, and so entities, are refused.

    Args:
        data: The document.
        path: Its file, for messages.

    Raises:
        ModelError: If it is not XML, too large, or has a document type.
    """
    if len(data) > MAX_BYTES:
        raise ModelError(f"{path}: longer than {MAX_BYTES // 2**20} MB")
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, dtd_validation=False,
        huge_tree=False, remove_comments=True, remove_pis=True,
    )  # fmt: skip
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        line, column = error.position
        raise ModelError(f"{path}:{line}:{column}: not XML: {error.msg}") from None
    if root.getroottree().docinfo.doctype:
        raise ModelError(f"{path}: a document type (DOCTYPE) is not allowed in a model")
    return root


def read_xml(path: Path) -> etree._Element:
    """Read and parse a file with `parse_xml`.

    Raises:
        ModelError: If it cannot be read or is not such a document.
    """
    try:
        data = read_bytes(path)
    except OSError as error:
        raise ModelError(f"{path}: cannot be read: {error.strerror}") from None
    return parse_xml(data, path)
