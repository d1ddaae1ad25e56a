"""Files whose trees other documents may name as sub-trees."""

from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Any

from .registry import BehaviourRegistry
from .stubs import Stubs
from .xml.check import check_elements
from .xml.dialect import Dialect
from .xml.document import Document, Sources, read_document
from .xml.problem import Problem, Problems
from .xml.verify import verify


class Libraries:
    """Files and folders of trees; each file is read once and checked once."""

    def __init__(self, paths: Iterable[str | Path] = ()) -> None:
        """Read the files.

        Args:
            paths: Files, and folders whose ``.xml`` files count where they hold trees.

        Raises:
            TreeError: If a file cannot be opened.
        """
        self.paths = tuple(map(Path, paths))
        self.sources = Sources()
        self.documents: list[Document] = []
        self._problems = Problems()
        for path in self.paths:
            files = sorted(path.rglob("*.xml")) if path.is_dir() else [path]
            for file in files:
                problems = Problems()
                document = read_document(file, problems, self.sources)
                if document is None or document.root.name == "root" or not path.is_dir():
                    self._problems.extend(problems)
                    if document is not None:
                        self.documents.append(document)
        self._checked: dict[str, list[Problem]] = {}

    def add_to(self, document: Document) -> None:
        """Let a document name the trees as sub-trees; its own trees of the same ID count."""
        for other in self.documents:
            document.add_library(other)

    def problems_of(self, files: Collection[str], *args: Any, **options: Any) -> list[Problem]:
        """Return what is wrong with some of the files, and what keeps any from being read.

        Args:
            files: Their names, as of places.
            *args: As of `problems`.
            **options: As of `problems`.
        """
        unread = set(self._problems)
        found = self.problems(*args, **options)
        return [problem for problem in found if problem.place.file in files or problem in unread]

    def problems(
        self,
        registry: BehaviourRegistry,
        dialect: Dialect,
        stubs: Stubs | None = None,
        *,
        strict: bool = True,
    ) -> list[Problem]:
        """Return all that is wrong with the files by themselves, found once for each dialect.

        Args:
            registry: The behaviours that they may name.
            dialect: How they are written.
            stubs: What stands for behaviours that nobody has.
            strict: Whether what BehaviorTree.CPP finds only at a tick is an error.
        """
        if dialect.name not in self._checked:
            found = Problems()
            found.extend(self._problems)
            for document in self.documents:
                known = registry if stubs is None else stubs.extend(document, registry)
                verify(document, known, found, dialect, strict=strict)
                if strict:
                    check_elements(document, known, found, dialect)
            self._checked[dialect.name] = list(found)
        return self._checked[dialect.name]
