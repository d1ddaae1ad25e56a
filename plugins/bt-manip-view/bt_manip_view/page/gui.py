"""Inputs and texts of the page: their state, and messages about its changes for browsers."""

import math
import threading
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

LONGEST_TEXT = 10_000
"""Largest number of characters of an entered text."""


class GuiEvent(NamedTuple):
    """Use of an element in a browser."""

    target: "GuiElement"
    value: Any


class GuiElement:
    """An element of the page.

    Its properties are attributes; setting one changes it in all browsers at the next update of the
    page. In the ``with`` block of a container, new elements are added to it. `Gui` makes elements.
    """

    def __init__(self, gui: "Gui", uid: int, kind: str, parent: int, props: dict[str, Any]) -> None:
        vars(self).update(_gui=gui, uid=uid, kind=kind, parent=parent, props=props, _calls={})

    def __getattr__(self, name: str) -> Any:
        """Return a property."""
        try:
            return self.props[name]
        except KeyError:
            raise AttributeError(f"the {self.kind} has no property '{name}'") from None

    def __setattr__(self, name: str, value: Any) -> None:
        """Set a property."""
        if name not in self.props:
            raise AttributeError(f"the {self.kind} has no property '{name}'")
        with self._gui._lock:
            if self.props[name] != value:
                self._gui._change(self, name, value)

    def __enter__(self) -> "GuiElement":
        """Enter the container: further elements are added to it."""
        self._gui._stack.append(self.uid)
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the container."""
        self._gui._stack.pop()

    def merge(self, name: str, values: dict[str, Any]) -> None:
        """Update entries of a property that is a dict; only these are sent."""
        with self._gui._lock:
            _, waiting = self._gui._changes.get((self.uid, name)) or ("merge", {})
            merged = {**self.props[name], **values}
            self._gui._change(self, name, merged, "merge", {**waiting, **values})

    def append(self, name: str, values: Sequence[Any], keep: int) -> None:
        """Append to a property that is a list, and keep its latest `keep` values."""
        with self._gui._lock:
            _, waiting, _ = self._gui._changes.get((self.uid, name)) or ("append", [], keep)
            appended = [*self.props[name], *values][-keep:]
            self._gui._change(self, name, appended, "append", [*waiting, *values][-keep:], keep)

    def on(self, event: str, call: Callable[[GuiEvent], None], accepts: Any = None) -> None:
        """Call a function with each event of a kind.

        Args:
            event: The kind.
            call: Called by the thread of the server; it should only set values for other threads.
            accepts: Returns whether the value of an event is valid; None: the event has no value.
        """
        self._calls.setdefault(event, []).append((call, accepts or (lambda value: value is None)))

    def on_click(self, call: Callable[[GuiEvent], None]) -> None:
        """Call a function at each click; in a group, the value is the label of the button."""
        self.on("click", call, self._is_option if "options" in self.props else None)

    def on_update(self, call: Callable[[GuiEvent], None]) -> None:
        """Call a function when the value is changed in a browser."""
        self.on("value", call, self.accepts)

    def remove(self) -> None:
        """Remove the element and its content."""
        self._gui._remove(self)

    def accepts(self, value: Any) -> bool:
        """Return whether a browser may set a value."""
        props = self.props
        if "value" not in props:
            return False
        if "options" in props:
            return self._is_option(value)
        if isinstance(props["value"], bool):
            return isinstance(value, bool)
        if isinstance(props["value"], int | float):
            low, high = props.get("min"), props.get("max")
            return is_number(value) and not (
                (low is not None and value < low) or (high is not None and value > high)
            )
        return isinstance(value, str) and len(value) <= LONGEST_TEXT

    def _is_option(self, value: Any) -> bool:
        return isinstance(value, str) and value in self.props["options"]


def is_number(value: Any) -> bool:
    """Return whether a value is a finite number."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


class Gui:
    """The elements of a page, common to all its browsers.

    Any thread may add, change and remove elements. `flush` returns the changes since its last call
    as one message; `snapshot` returns them with a message about all elements.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._elements: dict[int, GuiElement] = {}
        self._stack = [0]
        self._last = 0
        self._new: set[int] = set()
        self._gone: list[int] = []
        # By uid and property: None to set it, else the kind of the change and its arguments.
        self._changes: dict[tuple[int, str], tuple[Any, ...] | None] = {}

    def add(self, kind: str, **props: Any) -> GuiElement:
        """Add an element, of a kind that the script of the page knows, to the current container."""
        with self._lock:
            self._last += 1
            props = {"visible": True, "disabled": False, **props}
            element = GuiElement(self, self._last, kind, self._stack[-1], props)
            self._elements[element.uid] = element
            self._new.add(element.uid)
            return element

    def add_html(self, content: str) -> GuiElement:
        """Add HTML, the property ``content``; the caller escapes texts in it."""
        return self.add("html", content=content)

    def add_button(self, label: str, *, hint: str = "", style: str = "") -> GuiElement:
        """Add a button.

        Args:
            label: Its text.
            hint: Tooltip.
            style: ``primary`` for the main action, ``danger`` for a destructive one.
        """
        return self.add("button", label=label, hint=hint, style=style)

    def add_button_group(self, label: str, options: Sequence[str], *, hint: str = "") -> GuiElement:
        """Add a row of buttons; the value of an event is the label of its button."""
        return self.add("button_group", label=label, options=tuple(options), hint=hint)

    def add_checkbox(self, label: str, value: bool, *, hint: str = "") -> GuiElement:
        """Add a checkbox."""
        return self.add("checkbox", label=label, value=value, hint=hint)

    def add_dropdown(
        self,
        label: str,
        options: Sequence[str],
        *,
        initial_value: str | None = None,
        hint: str = "",
    ) -> GuiElement:
        """Add a dropdown list; default: its first option."""
        first = options[0] if initial_value is None else initial_value
        return self.add("dropdown", label=label, options=tuple(options), value=first, hint=hint)

    def add_slider(
        self, label: str, low: float, high: float, step: float, value: float, *, hint: str = ""
    ) -> GuiElement:
        """Add a slider."""
        return self.add("slider", label=label, min=low, max=high, step=step, value=value, hint=hint)

    def add_number(
        self, label: str, value: float, *, low: float | None = None, high: float | None = None,
        step: float | None = None, disabled: bool = False, hint: str = "",
    ) -> GuiElement:  # fmt: skip
        """Add an input for a number, with optional limits."""
        return self.add(
            "number", label=label, value=value, min=low, max=high, step=step, disabled=disabled,
            hint=hint,
        )  # fmt: skip

    def add_text(self, label: str, value: str, *, hint: str = "") -> GuiElement:
        """Add an input for a line of text."""
        return self.add("text", label=label, value=value, hint=hint)

    def add_plot(
        self, label: str, unit: str, names: Sequence[str], *, removable: bool = False
    ) -> GuiElement:
        """Add a line plot; each row of ``samples`` has the time and a value for each line.

        Args:
            label: Its title.
            unit: Unit of the values; empty without one.
            names: Names of the lines.
            removable: Whether it has a button, whose event is ``remove``.
        """
        return self.add(
            "plot", label=label, unit=unit, names=tuple(names), samples=[], removable=removable
        )

    def add_folder(self, label: str) -> GuiElement:
        """Add a container, collapsible if it has a label."""
        return self.add("folder", label=label)

    def flush(self) -> bytes | None:
        """Return the changes since the last call as JSON, or None without changes."""
        import msgspec  # not when plugins are loaded

        with self._lock:
            new = [e for uid in sorted(self._new) if (e := self._elements.get(uid)) is not None]
            message: list[Any] = [["remove", uid] for uid in self._gone]
            message += map(_description, new)
            for (uid, name), change in self._changes.items():
                if change is None:
                    message.append(["set", uid, {name: self._elements[uid].props[name]}])
                else:
                    message.append([change[0], uid, name, *change[1:]])
            for pending in (self._new, self._gone, self._changes):
                pending.clear()
            return msgspec.json.encode(message) if message else None

    def snapshot(self) -> tuple[bytes | None, bytes]:
        """Return the changes for connected browsers, and all elements for a new one."""
        import msgspec

        with self._lock:
            elements = [["reset"], *map(_description, self._elements.values())]
            return self.flush(), msgspec.json.encode(elements)

    def receive(self, data: Any) -> bool:
        """Process a browser's message; return whether it was valid. Invalid ones have no effect."""
        import msgspec

        try:
            message = msgspec.json.decode(data)
            uid, event, value = message["id"], message["event"], message.get("value")
        except (msgspec.MsgspecError, KeyError, TypeError, AttributeError, RecursionError):
            return False
        if type(uid) is not int or not isinstance(event, str):
            return False
        with self._lock:
            element = self._elements.get(uid)
            if element is None or element.disabled or not element.visible:
                return False
            if event == "value":
                if not element.accepts(value):
                    return False
                element.value = value
            called = [call for call, accepts in element._calls.get(event, ()) if accepts(value)]
        for call in called:
            call(GuiEvent(element, value))
        return bool(called) or event == "value"

    # For elements

    def _change(self, element: GuiElement, name: str, value: Any, *change: Any) -> None:
        """Set a property, for browsers by a smaller change unless they wait for all of it."""
        key = element.uid, name
        element.props[name] = value
        if element.uid not in self._new and element.uid in self._elements:
            if not change or self._changes.get(key, change) is not None:
                self._changes[key] = change or None

    def _remove(self, element: GuiElement) -> None:
        with self._lock:
            for inner in [one for one in self._elements.values() if one.parent == element.uid]:
                self._remove(inner)
            if self._elements.pop(element.uid, None) is None:
                return
            if element.uid in self._new:
                self._new.discard(element.uid)
            else:
                self._gone.append(element.uid)
            for key in [key for key in self._changes if key[0] == element.uid]:
                del self._changes[key]


def _description(element: GuiElement) -> list[Any]:
    return ["add", element.uid, element.parent, element.kind, element.props]


def rows_of(values: Iterable[Iterable[float]]) -> list[list[float]]:
    """Return rows of numbers for a plot, rounded to six digits."""
    return [[float(f"{value:.6g}") for value in row] for row in values]
