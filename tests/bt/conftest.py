"""Small trees from text, leaves that do what a list says, and a clock that stands still."""

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from bt_manip.bt import BehaviourRegistry, Tree, parse_tree
from tests.conformance.runner import Clock
from tests.support.corpus_leaves import corpus_registry
from tests.support.models import SHARED


@pytest.fixture(scope="session")
def engine_facts() -> Path:
    """Give the folder with the engine's traces and schema, or skip the test where it is missing."""
    root = Path(os.environ.get("BTCPP_ROOT", SHARED / "btcpp"))
    if not root.is_dir():
        pytest.skip(f"no traces of BehaviorTree.CPP at {root}")
    return root


def models_of(root: Any) -> dict[str, Any]:
    """Give kind and ports of each model by its ID; texts are documentation."""
    return {
        model.get("ID"): (
            model.tag,
            {p.get("name"): (p.tag, p.get("type"), p.get("default")) for p in model.iter()
             if p.tag.endswith("_port")},
        )
        for model in root.find("TreeNodesModel")
    }  # fmt: skip


@dataclass
class Bench:
    """A registry with scripted leaves, the log they write, and a clock.

    ``Scripted``, ``SyncScripted`` and ``ScriptedCondition`` walk a list of outcomes: S, F,
    R(unning) and K (skipped).
    """

    log: list[dict[str, Any]] = field(default_factory=list)
    clock: Clock = field(default_factory=Clock)

    def __post_init__(self) -> None:
        self.registry: BehaviourRegistry = corpus_registry(self.log)

    def tree(self, body: str, *others: str, **options: Any) -> Tree:
        """Read a tree ``Main`` with this content, and other trees beside it."""
        options.setdefault("strict", False)
        text = f'<root BTCPP_format="4" main_tree_to_execute="Main"><BehaviorTree ID="Main">{body}'
        text += "</BehaviorTree>" + "".join(others) + "</root>"
        return parse_tree(text, self.registry, clock=self.clock, **options)

    @property
    def events(self) -> list[str]:
        """What happened to the leaves: ``name event outcome``."""
        return [
            " ".join(str(e[key]) for key in ("node", "ev", "outcome", "child") if key in e)
            for e in self.log
        ]


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def leaf() -> Callable[..., str]:
    def write(name: str, outcomes: str, **attributes: str) -> str:
        more = "".join(f' {key}="{value}"' for key, value in attributes.items())
        return f'<Scripted name="{name}" outcomes="{",".join(outcomes)}"{more}/>'

    return write
