"""The choice of the next run, and the events between runs."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from bt_manip.runner import Run, Station

from .panel import Panel, message_html


class RunChoice(NamedTuple):
    """A run as it is chosen on the page."""

    tree: str
    scene: str
    robot: str
    seed: int
    cycles: int
    """Runs of the tree; 0 is without end."""


class SessionPanel(Panel):
    """Chooses tree, scene, robot, seed and cycles; asks to run the tree, or to reset the scene.

    It is hidden while a tree runs.

    Args:
        page: The page.
        names: The trees, scenes and robots to choose from, by ``tree``, ``scene``, ``robot``.
        first: The first choice.
        scene_of: Returns the scene in which a tree runs by default.
        seed_of: Returns the default seed of a scene.
    """

    place = "left"

    def __init__(
        self,
        page: Any,
        names: Mapping[str, Sequence[str]],
        first: RunChoice,
        scene_of: Callable[[str], str],
        seed_of: Callable[[str], int],
    ) -> None:
        self._scene_of, self._seed_of = scene_of, seed_of
        self._requests: deque[tuple[str, RunChoice]] = deque(maxlen=1)
        gui = page.gui
        with page.bar:
            self._run = gui.add_button("▶ Run", style="run", hint="Run the chosen tree")
            self._reset = gui.add_button("Reset", hint="Build the scene anew, as at the start")
        self._folder = gui.add_folder("")
        with self._folder:
            self._inputs = [
                gui.add_dropdown(kind.capitalize(), names[kind], initial_value=getattr(first, kind))
                for kind in ("tree", "scene", "robot")
            ]
            self._seed = gui.add_number("Seed", first.seed, low=0, step=1)
            self._cycles = gui.add_number(
                "Cycles", first.cycles, low=0, step=1, hint="Runs of the tree; 0 is without end"
            )
        self._message = gui.add_html("")
        with page.tabs, gui.add("tab", label="Result", visible=False, front=0) as self._tab:
            self._result = gui.add("result", status="", text="")
        for one in self._inputs:
            one.on_update(self._chosen)
        self._run.on_click(lambda _: self._requests.append(("run", self._choice())))
        self._reset.on_click(lambda _: self._requests.append(("reset", self._choice())))
        self._show(idle=False)

    def take(self) -> tuple[str, RunChoice] | None:
        """Return the last request, and forget it: ``show``, ``reset`` or ``run``.

        ``show`` asks for the cell of another tree, scene or robot.
        """
        return self._requests.pop() if self._requests else None

    def tell(self, message: str, *, error: bool = False) -> None:
        """Show one message below the choice; an empty one removes it."""
        self._message.content = message_html(message, error=error)

    def show_result(self, status: str, text: str) -> None:
        """Show how a run has ended, in front of the other tabs.

        Args:
            status: Its status.
            text: Its lines: the reason, the table of cycles, what to do next.
        """
        self._tab.visible = True
        self._result.status, self._result.text = status, text
        self._tab.front += 1

    def start(self, run: Run) -> None:
        """Show what runs in place of the choice."""
        self._show(idle=False)
        self._tab.visible = False
        self.tell("")

    def begin_idle(self, station: Station) -> None:
        """Show the choice."""
        self._show(idle=True)
        self.tell("")

    def _show(self, *, idle: bool) -> None:
        for one in (self._run, self._reset, self._folder):
            one.visible = idle

    # Callbacks

    def _choice(self) -> RunChoice:
        tree, scene, robot = (one.value for one in self._inputs)
        return RunChoice(tree, scene, robot, int(self._seed.value), int(self._cycles.value))

    def _chosen(self, event: Any) -> None:
        tree, scene, _ = self._inputs
        before = scene.value
        if event.target is tree and self._scene_of(tree.value) in scene.options:
            scene.value = self._scene_of(tree.value)
        if event.target is scene or scene.value != before:
            self._seed.value = self._seed_of(scene.value)
        self._requests.append(("show", self._choice()))
