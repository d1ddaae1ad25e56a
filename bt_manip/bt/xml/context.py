"""The state that all steps of reading a document share."""

from dataclasses import dataclass

from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.stubs import Stubs
from bt_manip.bt.xml.dialect import BTCPP, Dialect
from bt_manip.bt.xml.document import Document
from bt_manip.bt.xml.problem import Problems


@dataclass
class ReadingContext:
    """A document, the names that it may use, and the findings about it.

    Attributes:
        document: The document, its included files and libraries read.
        known: The behaviours that it may name, without stubs.
        problems: Collects errors and warnings.
        dialect: How it is written.
        stubs: Placeholders for unknown nodes and sub-trees; without them, these are errors.
        strict: Whether errors that the engine reports only at run time are errors here.
        registry: The behaviours that it may name, stubs and the nodes of the dialect included.
    """

    document: Document
    known: BehaviourRegistry
    problems: Problems
    dialect: Dialect = BTCPP
    stubs: Stubs | None = None
    strict: bool = True

    def __post_init__(self) -> None:
        """Add the nodes of the dialect, and declare the stubs.

        Raises:
            TreeError: If a stub does not suit its node.
        """
        self.known = self.dialect.extended(self.known)
        self.registry = self.known
        if self.stubs is not None:
            self.registry = self.stubs.extend(self.document, self.known)
