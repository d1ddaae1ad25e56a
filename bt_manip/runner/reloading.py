"""Editing a tree while it runs."""

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from bt_manip.bt import BehaviourRegistry, TreeWatch
from bt_manip.exceptions import BtManipError, NodeError
from bt_manip.files import noting
from bt_manip.models import is_address

from .observer import RunModifier
from .prepare import set_up
from .tree_source import TreeSource
from .xml_tree import set_keys

if TYPE_CHECKING:
    from .run import Run


class Reloader(RunModifier):
    """Takes up a tree's file between two ticks when it was edited, and tells what has come of it.

    Running nodes are halted, the blackboard stays, and the edited tree begins in the cell as it was
    at the start of the run; on a real robot the cell stays as it is. A file with errors changes
    nothing, and neither does one whose names the cell does not have. Only documents can be watched.
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
        self._run, self._objects = run, list(run.station.cell.entities)
        reading = run.request.reading
        main = self._source.function or reading.main
        self._watch = TreeWatch(run.tree, self._behaviours, reading, main=main)

    def before_tick(self) -> None:
        """Take up the file if it has changed."""
        run, tree = self._run, self._run.tree
        try:
            with noting(self._run.files):
                check = partial(set_up, station=run.station, more=self._objects)
                reading = self._watch.poll(check)
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
            self._emit_problems(*str(error).splitlines())
        else:
            if run.start is not None:
                run.station.return_to(run.start)
                run.station.randomizer.begin(run.cycle)
            self._tell(f"{self._source.path} was edited; the tree begins anew")
            self._emit_problems()

    def _emit_problems(self, *problems: str) -> None:
        self._run.events.emit("edit", {"problems": list(problems)})

    def _settings(self) -> dict[str, str]:
        """Return the settings for the tree, without those for objects of the scene."""
        return {
            key: text
            for key, text in self._run.request.settings.items()
            if not (is_address(text) and key in self._run.station.cell.objects)
        }
