"""The options of reading a tree document, as one value."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.runtime import Clock
from bt_manip.bt.substitution import Substitutions

if TYPE_CHECKING:
    from bt_manip.bt.libraries import Libraries
    from bt_manip.bt.stubs import Stubs


@dataclass(frozen=True)
class ReadingOptions:
    """How a tree document is read.

    Attributes:
        clock: Returns the time [s] of Delay, Timeout and Sleep.
        main: The tree to run; default: the main tree of the document.
        dialect: ``btcpp``, ``moveit-pro``, or ``auto`` to recognise it.
        blackboard: The root's entries that exist before.
        substitutions: Rules that replace nodes, for tests.
        libraries: Other files and folders whose trees may be named as sub-trees; `Libraries`
            that are given to several readings are read and checked once.
        stubs: Placeholders for unknown behaviours and sub-trees; by default these are errors.
        mapping: Rules that replace leaves and sub-trees of other projects by behaviours: a file,
            or what a dialect's `read_mapping` makes of it.
        strict: Whether the static checks, beyond the rules of the engine, are made.
        library: Whether a document needs no main tree.
        fatal_warnings: Whether all warnings are errors.
    """

    clock: Clock = time.monotonic
    main: str | None = None
    dialect: str = "btcpp"
    blackboard: Blackboard | Mapping[str, Any] | None = None
    substitutions: Substitutions | None = None
    libraries: "Sequence[str | Path] | Libraries" = ()
    stubs: "Stubs | None" = None
    mapping: Any = None
    strict: bool = True
    library: bool = False
    fatal_warnings: bool = False


DEFAULTS: Final = ReadingOptions()
