"""Trees from Python: a function that returns one, a behaviour or a tree."""

import importlib
import importlib.util
import inspect
import traceback
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.trees import BehaviourTree

from bt_manip.bt import Tree, TreeDefinition, TreeDocument, declarations
from bt_manip.exceptions import BtManipError, did_you_mean, shown
from bt_manip.files import read_bytes
from bt_manip.parameters import Parameter, parameters_of

from .tree_source import Clock, TreeSource


def make_tree(source: TreeSource, settings: Mapping[str, str], clock: Clock) -> Tree:
    """Return the tree that a Python name stands for.

    It is a behaviour, a tree, or a function that returns one of them and whose arguments are the
    keys of the tree, set by texts. Whatever is wrong raises a `BtManipError`.
    """
    return as_tree(make_any(source, settings), source, clock)


def as_tree(made: Any, source: TreeSource, clock: Clock) -> Tree:
    """Return a tree around a behaviour, a tree, or a document whose main tree is meant."""
    try:
        tree_id = source.function
        if isinstance(made, TreeDocument):
            made = made.main_tree()
            tree_id = made.tree_id or "MainTree"
        declared: dict[str, Any] = {}
        if isinstance(made, Tree):
            declared = {
                "goal": made.given_goal,
                "task": made.given_task, "results": made.results, "continues": made.continues,
            }  # fmt: skip
        elif isinstance(made, TreeDefinition):
            declared = {"goal": made.goal, **declarations(made.attributes)}
        root = made.root if isinstance(made, BehaviourTree | Tree | TreeDefinition) else made
        if isinstance(root, Behaviour):
            return Tree(root, clock=clock, tree_id=tree_id, **declared)
    except Exception as error:
        raise BtManipError(f"tree '{source.name}' {_raised(error)}") from error
    raise BtManipError(
        f"tree '{source.name}': the function returned {type(made).__name__}, "
        "a tree is a py_trees behaviour"
    )


def make_any(source: TreeSource, settings: Mapping[str, str]) -> Any:
    """Return the object that a Python name stands for: also a whole document of trees."""
    found = _find(source)
    is_tree = isinstance(found, Behaviour | BehaviourTree | Tree)
    arguments = _arguments(source, {} if is_tree else parameters_of(found), settings)
    try:
        return found if is_tree else found(**arguments)
    except Exception as error:
        raise BtManipError(f"tree '{source.name}' {_raised(error)}") from error


def _find(source: TreeSource) -> Any:
    try:
        module = _import(source)
    except Exception as error:
        if isinstance(error, ModuleNotFoundError) and error.name and source.module:
            if source.module == error.name or source.module.startswith(f"{error.name}."):
                raise BtManipError(
                    f"tree '{source.name}': there is no module '{source.module}'"
                ) from error
        raise BtManipError(f"tree '{source.name}' {_raised(error)}") from error
    found = getattr(module, source.function, None)
    trees = Behaviour | BehaviourTree | Tree
    if not (callable(found) or isinstance(found, trees)):
        names = [
            n for n, v in vars(module).items() if inspect.isfunction(v) or isinstance(v, trees)
        ]
        raise BtManipError(
            f"tree '{source.name}': there is no function or tree '{source.function}'"
            + did_you_mean(source.function, names)
        )
    return found


def _import(source: TreeSource) -> ModuleType:
    if source.path is None:
        assert source.module is not None
        module = importlib.import_module(source.module)
        if module.__file__:
            read_bytes(module.__file__)  # to note it
        return module
    # By its place and never through sys.path: a user's tree.py would shadow modules of others.
    name = f"_bt_manip_tree_{source.path.stem}"
    spec = importlib.util.spec_from_file_location(name, source.path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    read_bytes(source.path)  # to note it
    spec.loader.exec_module(module)
    return module


def _arguments(
    source: TreeSource, parameters: Mapping[str, Parameter], settings: Mapping[str, str]
) -> dict[str, Any]:
    for key in settings:
        if key not in parameters:
            near = did_you_mean(key, parameters)
            raise BtManipError(f"the tree '{source.name}' has no key '{key}'{near}")
    for key, parameter in parameters.items():
        if parameter.mandatory and key not in settings:
            raise BtManipError(
                f"the tree '{source.name}' needs --set {key}=VALUE: it has no default"
            )
    values = {}
    for key, text in settings.items():
        try:
            values[key] = parameters[key].read(text)
        except ValueError:
            wanted = parameters[key].wanted
            raise BtManipError(f"--set {key}: expected {wanted}, got {shown(text)}") from None
    return values


def _raised(error: Exception) -> str:
    """Describe an exception of a user's code, with its location."""
    if isinstance(error, SyntaxError) and error.filename:
        return f"is no Python: {Path(error.filename).name}:{error.lineno}: {error.msg}"
    if isinstance(error, BtManipError):
        return f"cannot be made: {error}"
    frames = traceback.extract_tb(error.__traceback__)
    where = f" at {frames[-1].filename}:{frames[-1].lineno}" if frames else ""
    return f"raised {type(error).__name__}{where}: {error}"
