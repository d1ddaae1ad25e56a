"""Tests of all parts or trees of a plugin, by one line of a test module.

The parts are looked up when pytest collects the tests, so that importing this module is cheap.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from bt_manip.testing.coverage import TreeCoverage
    from bt_manip.testing.tree_runs import EndState

CONTRACTS = "bt_manip_contracts"
"""Marker of a test that is run once per contract check."""

COVERAGE: "pytest.StashKey[TreeCoverage]" = pytest.StashKey()
"""Key of a pytest session's tree coverage."""

TREES = "bt_manip_trees"
"""Marker of a test that is run once per tree."""


def contracts_of(
    plugin: str,
    *,
    examples: Mapping[str, Any] | None = None,
    parameters: Mapping[str, Mapping[str, Any]] | None = None,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
    without: tuple[str, ...] = (),
) -> Callable[..., None]:
    """Return the test of all objects, robots, controllers, behaviours, trees, ... of a plugin.

    ```python
    test_contracts = contracts_of("blocks", examples={"PlaceOn": Example({"support": "table"})})
    ```

    Args:
        plugin: Name of the plugin, as ``bt-manip plugins`` lists it.
        examples: `bt_manip.testing.Example` by name of the behaviour; not needed for behaviours
            without required ports.
        parameters: Parameters of objects, by name.
        settings: Values of the keys of trees, by name.
        without: Names of parts, as ``"cube"`` or ``"tree stack"``, or ``"part: check"``, to leave
            out.
    """

    @pytest.mark.bt_manip_contracts(
        plugin,
        examples=examples or {},
        parameters=parameters or {},
        settings=settings or {},
        without=without,
    )
    def test_contract(bt_manip_contract: Callable[[Any], None], situations: Any) -> None:
        bt_manip_contract(situations)

    return test_contract


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
