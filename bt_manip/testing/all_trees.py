"""Tests of all trees of a plugin, by one line of a test module.

The trees are looked up when pytest collects the tests, so that importing this module is cheap.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from bt_manip.testing.coverage import TreeCoverage
    from bt_manip.testing.tree_runs import EndState

COVERAGE: "pytest.StashKey[TreeCoverage]" = pytest.StashKey()
"""Key of a pytest session's tree coverage."""

TREES = "bt_manip_trees"
"""Marker of a test that is run once per tree."""


def trees_of(
    where: str | Path,
    *,
    end_states: "Mapping[str, EndState] | None" = None,
    cycles: int = 1,
    seed: int = 0,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
    **choice: Any,
) -> Callable[..., None]:
    """Return the test that runs all trees of a plugin or a folder.

    ```python
    test_trees = trees_of("blocks", end_states={"stack_blocks": a_tower_stands})
    ```

    Args:
        where: Name of the plugin, or a folder of ``*.xml``.
        end_states: Function of the station that asserts the end state of a successful tree, by
            the tree's name.
        cycles: Number of runs of each.
        seed: Seed of all randomness.
        settings: Values of the keys of a tree, by its name.
        **choice: ``robot``, ``controller``, ... of `bt_manip.runner.RunRequest`.
    """

    @pytest.mark.bt_manip_trees(
        where,
        {
            "end_states": end_states or {},
            "settings": settings or {},
            "run": {"cycles": cycles, "seed": seed, **choice},
        },
    )
    def test_tree(bt_manip_tree_run: Callable[..., None], parts: Any, request: Any) -> None:
        bt_manip_tree_run(parts, request.config.stash.get(COVERAGE, None))

    return test_tree
