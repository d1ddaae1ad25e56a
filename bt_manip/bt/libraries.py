"""Files whose trees other documents may name as sub-trees."""

from collections.abc import Collection, Iterable
from dataclasses import replace
from pathlib import Path

from .xml.document import Document, Sources, read_document
from .xml.problem import Problem, Problems
from .xml.reader import read_trees
from .xml.specs import ReadingContext


class Libraries:
    """Files and folders of trees; each file is read once and checked once.

    Args:
        paths: Files, and folders whose ``.xml`` files count where they hold trees.
        sources: Those of other libraries: files that were read before, and are not read again.

    Raises:
        TreeError: If a file cannot be opened.
    """

    def __init__(self, paths: Iterable[str | Path] = (), sources: Sources | None = None) -> None:
        self.paths = tuple(map(Path, paths))
        self.sources = Sources() if sources is None else sources
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
        self._checked: dict[tuple[str, str], list[Problem]] = {}
        self._extended: dict[tuple[Path, ...], Libraries] = {}

    @classmethod
    def of(cls, given: "Iterable[str | Path] | Libraries") -> "Libraries":
        """Return the libraries, with paths replaced by the libraries in these files."""
        return given if isinstance(given, Libraries) else cls(given)

    def extended(self, paths: tuple[Path, ...]) -> "Libraries":
        """Return these libraries and further ones, whose trees of the same ID do not count."""
        if not paths:
            return self
        if paths not in self._extended:
            self._extended[paths] = Libraries((*self.paths, *paths), self.sources)
        return self._extended[paths]

    def add_to(self, document: Document) -> None:
        """Let a document name the trees as sub-trees; its own trees of the same ID count.

        The files stay out of its `order`: their form is checked here.
        """
        for other in self.documents:
            document.trees = {**other.trees, **document.trees}
            document.models = {**other.models, **document.models}
            document.sources = {**other.sources, **document.sources}

    def problems_of(self, files: Collection[str], context: ReadingContext) -> list[Problem]:
        """Return the problems of some of the files, and those of files that cannot be read.

        Args:
            files: Their names, as of places.
            context: The document that names trees of the files.
        """
        problems, unread = Problems(), set(self._problems)
        problems.extend(self._problems)
        for document in self.documents:
            own = document.file in context.document.order  # which was checked already
            if not own and any(file in files for file in document.sources):
                problems.extend(self._checked_by_itself(document, context))
        return [p for p in problems if p.place.file in files or p in unread]

    def _checked_by_itself(self, document: Document, context: ReadingContext) -> list[Problem]:
        """Return the problems of a file, which is checked once for each dialect."""
        key = context.dialect.name, document.file
        if key not in self._checked:
            problems = Problems(hints=10)  # a hint takes long, and there may be many files
            read_trees(replace(context, document=document, problems=problems))
            self._checked[key] = list(problems)
        return self._checked[key]
