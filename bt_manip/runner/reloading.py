"""Editing a tree while it runs."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from bt_manip.bt import BehaviourRegistry, TreeWatch
from bt_manip.exceptions import BtManipError, NodeError
from bt_manip.models import is_address

from .observer import RunModifier
from .tree_source import TreeSource
from .xml_tree import set_keys

if TYPE_CHECKING:
    from .run import Run


class Reloader(RunModifier):
    """Takes up a tree's file between two ticks when it was edited.

    Running nodes are halted, the blackboard stays, and the edited tree goes on from its root. A
    file with errors changes nothing.

    Args:
        source: The tree.
        behaviours: The behaviours that it may name.
        tell: Takes what has come of an edit, for people.

    Raises:
        BtManipError: When the tree is no document.
    """

    def __init__(
        self, source: TreeSource, behaviours: BehaviourRegistry, tell: Callable[[str], None]
    ) -> None:
        if source.kind != "xml":
            raise BtManipError(
                f"--watch: '{source.name}' is a Python function; only a tree's .xml can be watched"
            )
        self._source, self._behaviours, self._tell = source, behaviours, tell

    def run_started(self, run: "Run") -> None:
        """Begin to watch."""
        self._run = run
        reading = run.request.reading
        main = self._source.function or reading.main
        self._watch = TreeWatch(run.tree, self._behaviours, reading, main=main)

    def before_tick(self) -> None:
        """Take up the file if it has changed."""
        tree = self._run.tree
        try:
            reading = self._watch.poll()
            if reading is None:
                return
            for problem in reading.problems:
                self._tell(str(problem))
            if reading.tree is None or reading.errors:
                self._tell(f"{self._source.path} has errors; the tree goes on as it was")
                self._emit_problems(*map(str, reading.errors))
                return
            set_keys(self._source, tree, self._settings(), only_new=True)
        except (BtManipError, NodeError) as error:
            self._tell(str(error))
            self._emit_problems(str(error))
        else:
            self._tell(f"{self._source.path} was edited; the tree begins anew")
            self._emit_problems()

    def _emit_problems(self, *problems: str) -> None:
        """Emit the problems of the edited file."""
        self._run.events.emit("edit", {"problems": list(problems)})

    def _settings(self) -> dict[str, str]:
        """Return the settings for the tree, without those for objects of the scene."""
        return {
            key: text
            for key, text in self._run.request.settings.items()
            if not (is_address(text) and key in self._run.station.cell.objects)
        }
