"""The state that all steps of reading a document share."""

from dataclasses import dataclass, field

from bt_manip.bt.reading_options import ReadingOptions
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.xml.dialect import Dialect
from bt_manip.bt.xml.document import Document
from bt_manip.bt.xml.problem import Problems


@dataclass
class ReadingContext:
    """A document, its included files and libraries read, and the findings about it.

    `known` are the behaviours that it may name; `registry` has stubs and the dialect's nodes, too.
    """

    document: Document
    known: BehaviourRegistry
    problems: Problems
    dialect: Dialect
    options: ReadingOptions
    registry: BehaviourRegistry = field(init=False)

    def __post_init__(self) -> None:
        """Add the nodes of the dialect, and declare the stubs."""
        self.known = self.registry = self.known.of_dialect(self.dialect)
        if self.options.stubs is not None:
            self.registry = self.options.stubs.extend(self.document, self.known, self.problems)
