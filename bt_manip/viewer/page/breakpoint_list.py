"""The list of breakpoints, with a button to remove each."""

from typing import Any


class BreakpointList:
    """A button for each breakpoint, which removes it."""

    def __init__(self, gui: Any, controls: Any) -> None:
        """Add it to the current container.

        Args:
            gui: viser's ``GuiApi``.
            controls: The `Controls`, which obey the breakpoints.
        """
        self._gui, self._controls = gui, controls
        self._folder = gui.add_folder("Breakpoints", visible=False)
        self._buttons: dict[str, Any] = {}

    def toggle(self, path: str) -> None:
        """Set a breakpoint at a node, or remove it."""
        self._controls.breakpoints ^= {path}

    def draw(self) -> None:
        """Add and remove buttons as the breakpoints have changed."""
        wanted = self._controls.breakpoints
        for path in [path for path in self._buttons if path not in wanted]:
            self._buttons.pop(path).remove()
        with self._folder:
            for path in sorted(wanted - set(self._buttons)):
                button = self._gui.add_button(
                    f"✕ {path}", color="gray", hint="Remove this breakpoint"
                )
                button.on_click(lambda _, path=path: self.toggle(path))
                self._buttons[path] = button
        self._folder.visible = bool(wanted)
