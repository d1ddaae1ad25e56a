"""Options for trees whose nodes or sub-trees nobody here has."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.options import option
from bt_manip.exceptions import BtManipError, did_you_mean

if TYPE_CHECKING:
    from bt_manip.bt import ReadingOptions

_PATH = click.Path(exists=True, path_type=Path)


@dataclass(frozen=True)
class ForeignTrees:
    """Values of the options."""

    dialect: str = option(
        "--dialect", group="Trees of others", default="auto", metavar="NAME",
        shell_complete=complete_part("dialects"),
        help="Dialect of the document: btcpp, or one of bt-manip list dialects.  [default: it is "
        "recognised]",
    )  # fmt: skip
    stubs: tuple[str, ...] = option(
        "--stub", group="Trees of others", multiple=True, metavar="NAME=RESULT",
        help="Let a leaf or sub-tree return SUCCESS, FAILURE or RUNNING, or any node be another "
        "one: RecoveryNode=Fallback; may be given more than once.",
    )  # fmt: skip
    stub_unknown: bool = option(
        "--stub-unknown", group="Trees of others", is_flag=True,
        help="Let all leaves and sub-trees that are not known succeed.",
    )  # fmt: skip
    models: tuple[Path, ...] = option(
        "--models", group="Trees of others", multiple=True, type=_PATH, metavar="FILE",
        help="A file whose TreeNodesModel declares nodes, such as a project of Groot2; may be "
        "given more than once.",
    )  # fmt: skip
    mapping: Path | None = option(
        "--map", group="Trees of others", type=_PATH, metavar="FILE.toml",
        help="Which behaviours stand for leaves and sub-trees of others, and how.",
    )  # fmt: skip
    libraries: tuple[Path, ...] = option(
        "--with", group="Trees of others", multiple=True, type=_PATH, metavar="PATH",
        help="A file or folder whose trees may be named as sub-trees; may be given more than once.",
    )  # fmt: skip
    _stubbed: dict[str, int] = field(default_factory=dict)

    def reading(self) -> "ReadingOptions":
        """Return the options of reading a document of any dialect.

        Raises a `BtManipError` if a library cannot be read or a stub has another form.
        """
        from bt_manip.bt import Libraries, ReadingOptions, Stubs

        results: dict[str, str] = {}
        for text in self.stubs:
            name, equals, result = (part.strip() for part in text.rpartition("="))
            if not equals or not name or not result:
                raise BtManipError(
                    f"--stub wants NAME=RESULT, as in \"MoveToPose=FAILURE\", got '{text}'"
                )
            results[name] = result
        return ReadingOptions(
            dialect=self.dialect,
            stubs=Stubs(self.stub_unknown, results, self.models),
            libraries=Libraries(self.libraries),
            mapping=self.mapping,
        )

    def fields(self) -> dict[str, Any]:
        """Return the options that were given, as plain data."""
        given = {
            "dialect": self.dialect if self.dialect != "auto" else None,
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
            fields.get("dialect", "auto"),
            tuple(fields.get("stubs", ())),
            fields.get("stub_unknown", False),
            tuple(map(Path, fields.get("models", ()))),
            Path(mapping) if mapping else None,
            tuple(map(Path, fields.get("libraries", ()))),
        )

    def note(self, stubbed: Mapping[str, int]) -> None:
        """Remember the stubs of one more tree."""
        for text, count in stubbed.items():
            self._stubbed[text] = self._stubbed.get(text, 0) + count

    def print_stubs(self) -> None:
        """Print the stubs of the trees, and requested stubs that no tree used."""
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
