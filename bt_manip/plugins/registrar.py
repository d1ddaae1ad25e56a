"""The parts of one plugin, before they are added to the parts of all plugins."""

import inspect
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.registry import Parts, TreeDefaults


class Registrar:
    """Collects the parts of one plugin until all of its hooks have returned."""

    def __init__(self, owner: str, parts: Parts) -> None:
        self._owner = owner
        self._parts = parts.by_kind()
        self._all_defaults = parts.tree_defaults
        self._defaults: dict[str, TreeDefaults] = {}
        self._items: dict[str, dict[str, Any]] = {kind: {} for kind in self._parts}
        self._open = True

    def register(
        self, kind: str, check: Callable[[str, Any], None] | None = None
    ) -> Callable[..., None]:
        """Return the function ``register`` of the hook for a kind of parts.

        It raises a `BtManipError` for invalid arguments; `check` is that of `hookspec`.
        """
        add_factory = partial(self._add_factory, kind)
        take: Callable[..., None] = getattr(self, f"_register_{kind}", add_factory)
        if check is not None:
            take = partial(self._add_checked, kind, check)
        signature = inspect.signature(take)

        def register(*arguments: Any, **named: Any) -> None:
            try:
                signature.bind(*arguments, **named)
            except TypeError as error:
                names = ", ".join(signature.parameters)
                raise BtManipError(f"register({names}) was called wrongly: {error}") from None
            take(*arguments, **named)

        return register

    def merge(self) -> dict[str, tuple[str, ...]]:
        """Merge the parts into those of all plugins; return their names by kind."""
        self._open = False
        self._check_kinds()
        for kind, items in self._items.items():
            for name, item in items.items():
                self._parts[kind].add(name, item, self._owner)
        self._all_defaults.update(self._defaults)
        return {kind: tuple(sorted(items)) for kind, items in self._items.items() if items}

    def _add(self, kind: str, name: object, item: object) -> None:
        if not self._open:
            raise BtManipError("'register' is to be called inside the hook, not later")
        registry = self._parts[kind]
        registry.check(name)
        assert isinstance(name, str)  # by check()
        if name in self._items[kind]:
            raise BtManipError(f"it registers {registry.kind} '{name}' twice")
        self._items[kind][name] = item

    def _add_checked(
        self, kind: str, check: Callable[[str, Any], None], name: str, part: Any
    ) -> None:
        check(name, part)
        self._add(kind, name, part)

    def _add_factory(self, kind: str, name: str, factory: Callable[..., Any]) -> None:
        if not callable(factory):
            raise BtManipError(f"'{name}' among its {kind} is not callable: {factory!r}")
        if inspect.isabstract(factory):
            missing = ", ".join(sorted(getattr(factory, "__abstractmethods__", ())))
            raise BtManipError(f"'{name}' among its {kind} is incomplete: it lacks {missing}")
        self._add(kind, name, factory)

    def _register_objects(self, name: str, factory: Callable[..., Any]) -> None:
        self._add_factory("objects", name, factory)
        from bt_manip.cell import as_object
        from bt_manip.cell.objects import check_spelling

        category: Any = as_object(factory).category
        if category != "" and not isinstance(category, property):
            try:
                check_spelling(category)
            except BtManipError as error:
                raise BtManipError(f"object '{name}': {error}") from None

    def _check_kinds(self) -> None:
        """Raise an error for an object that a snapshot could not recreate by its ``kind``."""
        known = {*self._parts["objects"], *self._items["objects"]}
        if not self._items["objects"]:
            return
        from bt_manip.cell import as_object

        for name, factory in self._items["objects"].items():
            kind: Any = as_object(factory).kind
            if isinstance(kind, str) and kind not in known:
                raise BtManipError(
                    f"object '{name}' has the kind '{kind}', from which a snapshot could not "
                    f"recreate it{did_you_mean(kind, [name])}"
                )

    def _register_robots(self, description: Any) -> None:
        if not hasattr(description, "name") or not hasattr(description, "arm_joints"):
            raise BtManipError(f"a robot is a RobotDescription, got {description!r}")
        self._add("robots", description.name, description)

    def _register_commands(self, name: str, target: Any, group: str = "") -> None:
        callback = getattr(target, "callback", None)  # of a click command
        if callback is not None:
            target = f"{callback.__module__}:{callback.__name__}"
        if not isinstance(target, str) or not target.partition(":")[2].isidentifier():
            problem = f"a click command or its place 'module:function', got {target!r}"
            raise BtManipError(f"the target of command '{name}' is {problem}")
        self._add("commands", f"{group}-{name}" if group else name, target)

    def _register_backends(self, name: str, backend: Any) -> None:
        from bt_manip.robots import Backend

        if not isinstance(backend, Backend):
            raise BtManipError(f"backend '{name}' is no Backend: {backend!r}")
        self._add("backends", name, backend)

    def _register_model_formats(self, name: str, format: Any) -> None:
        from bt_manip.models import ModelFormat

        if not isinstance(format, ModelFormat):
            raise BtManipError(f"model format '{name}' is no ModelFormat: {format!r}")
        others = self._parts["model_formats"].copies() | self._items["model_formats"]
        for other, known in others.items():
            both = {*format.suffixes, format.tag} & {*known.suffixes, known.tag} - {""}
            if both:
                raise BtManipError(
                    f"model format '{name}': '{min(both)}' belongs to the format '{other}'"
                )
        self._add("model_formats", name, format)

    def _register_behaviours(self, cls: type, name: str | None = None) -> None:
        if not isinstance(cls, type):
            raise BtManipError(f"a behaviour is registered as a class, got {cls!r}")
        from bt_manip.bt import BehaviourRegistry
        from bt_manip.bt.nodes import Action

        # A new registry has the nodes of the language: it rejects their names, and classes
        # that are not nodes.
        BehaviourRegistry().register(cls, name)
        if getattr(cls, "update", None) is Action.update:
            raise BtManipError(f"behaviour '{cls.__name__}' has no 'update'")
        if hasattr(cls, "initialize"):
            raise BtManipError(
                f"behaviour '{cls.__name__}' has an 'initialize', which nobody calls; did you mean "
                "'initialise'?"
            )
        self._add("behaviours", name or cls.__name__, cls)

    def _register_dialects(self, dialect: Any) -> None:
        from bt_manip.bt import Dialect

        if not isinstance(dialect, Dialect):
            raise BtManipError(f"a dialect is a Dialect, got {dialect!r}")
        self._add("dialects", dialect.name, dialect)

    def _register_trees(
        self,
        name: str,
        place: str | Path,
        *,
        scene: str | None = None,
        controller: str | None = None,
    ) -> None:
        text = str(place)
        path, _, function = text.rpartition(":")
        is_xml = text.endswith(".xml") and Path(text).is_file()
        is_python = path.endswith(".py") and Path(path).is_file() and function.isidentifier()
        if not is_xml and not is_python:
            raise BtManipError(
                f"tree '{name}': '{text}' is neither a path.xml nor a path.py:function that exists"
            )
        self._add("trees", name, str(Path(text).absolute()))
        if scene is not None or controller is not None:
            self._defaults[name] = TreeDefaults(scene, controller)
