"""One line in a test module, and all that a plugin brings is held to its contracts.

Cheap to import: what a plugin brings is looked up when pytest collects the tests.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from bt_manip.testing.coverage import TreeCoverage
    from bt_manip.testing.tree_runs import EndState

CONTRACTS = "bt_manip_contracts"
"""Name of the marker that asks for a test a contract."""

COVERAGE: "pytest.StashKey[TreeCoverage]" = pytest.StashKey()
"""Where a pytest session keeps the coverage of trees."""

TREES = "bt_manip_trees"
"""Name of the marker that asks for a test a tree."""


def contracts_of(
    plugin: str,
    *,
    examples: Mapping[str, Any] | None = None,
    parameters: Mapping[str, Mapping[str, Any]] | None = None,
    without: tuple[str, ...] = (),
) -> Callable[..., None]:
    """Make the test of all objects, robots, controllers and behaviours that a plugin brings.

    ```python
    test_contracts = contracts_of("blocks", examples={"PlaceOn": Example({"support": "table"})})
    ```

    Args:
        plugin: Name of the plugin, as ``bt-manip plugins`` lists it.
        examples: How behaviours are used, `bt_manip.testing.behaviour_contract.Example` by name;
            those without ports that must be given need none.
        parameters: Parameters to make objects with, by name.
        without: Names of parts, or ``"part: check"``, that are left out.
    """

    @pytest.mark.bt_manip_contracts(
        plugin, examples=examples or {}, parameters=parameters or {}, without=without
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
    """Make the test that runs all trees of a plugin, or of a folder, headless.

    ```python
    test_trees = trees_of("blocks", end_states={"stack_blocks": a_tower_stands})
    ```

    Args:
        where: Name of the plugin, or a folder of ``*.xml``.
        end_states: What has to hold when a tree has succeeded, by its name: a function that gets
            the station and asserts.
        cycles: How often to run each.
        seed: Seed of all randomness.
        settings: Values for keys that a tree declares, by its name.
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
