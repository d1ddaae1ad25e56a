"""Selection of the next run."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from bt_manip.runner import Run, Station

from .panel import Panel, message_html


class RunChoice(NamedTuple):
    """A run selected on the page."""

    tree: str
    scene: str
    robot: str
    seed: int
    cycles: int
    """Number of cycles; 0: unlimited."""


class SessionPanel(Panel):
    """Selects tree, scene, robot, seed and cycles; requests a run or a reset of the scene.

    Hidden while a tree runs.

    Args:
        page: The page.
        names: The registered trees, scenes and robots, by ``tree``, ``scene``, ``robot``.
        first: The initial selection, which is offered, too.
        scene_of: Returns the default scene of a tree.
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
            self._run = gui.add_button("▶ Run", style="run", hint="Run the selected tree")
            self._reset = gui.add_button("Reset", hint="Rebuild the scene as at the start")
        self._folder = gui.add_folder("")
        with self._folder:
            self._inputs = [
                gui.add_dropdown(
                    kind.capitalize(), list(dict.fromkeys([getattr(first, kind), *names[kind]]))
                )
                for kind in ("tree", "scene", "robot")
            ]
            self._seed = gui.add_number("Seed", first.seed, low=0, step=1)
            self._cycles = gui.add_number(
                "Cycles", first.cycles, low=0, step=1, hint="Number of cycles; 0 is unlimited"
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
        """Return the last request and clear it: ``show``, ``reset`` or ``run``.

        ``show`` requests the cell of another tree, scene or robot.
        """
        return self._requests.pop() if self._requests else None

    def tell(self, message: str, *, error: bool = False) -> None:
        """Show a message below the selection; an empty one removes it."""
        self._message.content = message_html(message, error=error)

    def show_result(self, status: str, text: str) -> None:
        """Show status and text of the result of a run in front of the other tabs."""
        self._tab.visible = True
        self._result.status, self._result.text = status, text
        self._tab.front += 1

    def start(self, run: Run) -> None:
        """Hide the selection and the last result."""
        self._show(idle=False)
        self._tab.visible = False
        self.tell("")

    def begin_idle(self, station: Station) -> None:
        """Show the selection."""
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
