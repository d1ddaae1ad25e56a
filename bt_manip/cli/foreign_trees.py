"""Options for trees whose nodes or sub-trees nobody here has."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from bt_manip.exceptions import BtManipError, did_you_mean

if TYPE_CHECKING:
    pass

Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True)
class ForeignTrees:
    """What the options say.

    Attributes:
        libraries: Files and folders whose trees may be named as sub-trees.
        models: Files that declare nodes.
        stub_unknown: Whether leaves and sub-trees that nobody has succeed.
        stubs: ``NAME=RESULT``, as given.
        mapping: A file that maps leaves to behaviours.
    """

    libraries: tuple[Path, ...] = ()
    models: tuple[Path, ...] = ()
    stub_unknown: bool = False
    stubs: tuple[str, ...] = ()
    mapping: Path | None = None
    _stubbed: dict[str, int] = field(default_factory=dict)

    def reading(self) -> dict[str, Any]:
        """Give the options for `bt_manip.bt.read_tree`; libraries are read now.

        Raises:
            BtManipError: If a file cannot be read, or a stub is not of the form ``NAME=RESULT``.
        """
        from bt_manip.bt import LeafMapping, Libraries, Stubs

        results: dict[str, str] = {}
        for text in self.stubs:
            name, equals, result = (part.strip() for part in text.rpartition("="))
            if not equals or not name or not result:
                raise BtManipError(
                    f"--stub wants NAME=RESULT, as in \"MoveToPose=FAILURE\", got '{text}'"
                )
            results[name] = result
        stubs: Stubs = Stubs(self.stub_unknown, results, self.models)
        libraries: Libraries = Libraries(self.libraries)
        mapping = None if self.mapping is None else LeafMapping.read(self.mapping)
        return {"stubs": stubs, "libraries": libraries, "mapping": mapping}

    def fields(self) -> dict[str, Any]:
        """Return the options that were given, as plain data."""
        given = {
            "libraries": list(map(str, self.libraries)),
            "models": list(map(str, self.models)),
            "stub_unknown": self.stub_unknown,
            "stubs": list(self.stubs),
            "mapping": None if self.mapping is None else str(self.mapping),
        }
        return {name: value for name, value in given.items() if value}

    @classmethod
    def of(cls, fields: Mapping[str, Any]) -> "ForeignTrees":
        """Return the options of some `fields`."""
        mapping = fields.get("mapping")
        return cls(
            tuple(map(Path, fields.get("libraries", ()))),
            tuple(map(Path, fields.get("models", ()))),
            fields.get("stub_unknown", False),
            tuple(fields.get("stubs", ())),
            Path(mapping) if mapping else None,
        )

    def note(self, stubbed: Mapping[str, int]) -> None:
        """Remember what was stubbed in one more tree."""
        for text, count in stubbed.items():
            self._stubbed[text] = self._stubbed.get(text, 0) + count

    def report(self) -> None:
        """Print what was stubbed, and which stubs no tree had a use for."""
        if self._stubbed:
            click.echo("Stubs:", err=True)
        for text, count in sorted(self._stubbed.items()):
            click.echo(f"  {text}" + (f" x {count}" if count > 1 else ""), err=True)
        used = {text.rpartition(" (")[0] for text in self._stubbed}
        for text in self.stubs:
            name = text.rpartition("=")[0].strip()
            if name not in used:
                near = did_you_mean(name, used) if used else ""
                click.echo(f"Warning: --stub: nothing is named '{name}'{near}", err=True)


def foreign_tree_options(command: Function) -> Function:
    """Add the options to a command, which gets them as ``foreign``, a `ForeignTrees`."""
    names = ("libraries", "models", "stub_unknown", "stubs", "mapping")

    def with_options(*args: Any, **options: Any) -> Any:
        foreign = ForeignTrees(**{name: options.pop(name) for name in names})
        return command(*args, foreign=foreign, **options)

    with_options.__doc__ = command.__doc__
    with_options.__name__ = command.__name__
    with_options.__dict__.update(command.__dict__)
    path = click.Path(exists=True, path_type=Path)
    for option in (
        click.option(
            "--stub", "stubs", multiple=True, metavar="NAME=RESULT",
            help="Let a leaf or sub-tree return SUCCESS, FAILURE or RUNNING, or any node be "
            "another one: RecoveryNode=Fallback; may be given more than once.",
        ),
        click.option(
            "--stub-unknown", is_flag=True,
            help="Let all leaves and sub-trees that are not known succeed.",
        ),
        click.option(
            "--models", multiple=True, type=path, metavar="FILE",
            help="A file whose TreeNodesModel declares nodes, such as a project of Groot2; may "
            "be given more than once.",
        ),
        click.option(
            "--map", "mapping", type=path, metavar="FILE.toml",
            help="Which behaviours stand for leaves and sub-trees of others, and how.",
        ),
        click.option(
            "--with", "libraries", multiple=True, type=path, metavar="PATH",
            help="A file or folder whose trees may be named as sub-trees; may be given more "
            "than once.",
        ),
    ):  # fmt: skip
        option(with_options)
    return with_options  # type: ignore[return-value]
