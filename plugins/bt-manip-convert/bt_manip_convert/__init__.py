"""Conversion of trees: a document as Python source that builds the same document."""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip_convert.python_source import to_python as to_python

__getattr__ = lazy_exports(__name__)
