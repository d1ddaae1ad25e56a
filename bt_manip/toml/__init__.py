"""TOML files: keys declared as fields of dataclasses, checked reading, and writing."""

from .fields import Key as Key
from .fields import KeyField as KeyField
from .fields import OtherKeys as OtherKeys
from .fields import Tables as Tables
from .fields import check_fields as check_fields
from .fields import documented as documented
from .fields import entries_of as entries_of
from .fields import plain as plain
from .fields import pose_entries as pose_entries
from .fields import read_fields as read_fields
from .fields import read_part as read_part
from .fields import write_fields as write_fields
from .lines import line_numbers as line_numbers
from .lines import line_of as line_of
from .parsing import MAX_TOML_BYTES as MAX_TOML_BYTES
from .parsing import MAX_TOML_NESTING as MAX_TOML_NESTING
from .parsing import parse_toml as parse_toml
from .parsing import read_toml as read_toml
from .tables import PythonSource as PythonSource
from .tables import TomlFile as TomlFile
from .tables import TomlTable as TomlTable
from .text import toml_text as toml_text
