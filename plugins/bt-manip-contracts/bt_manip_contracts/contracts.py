"""Tests of all parts of a plugin, by one line of a test module.

The parts are looked up when pytest collects the tests, so that importing this module is cheap.
"""

from collections.abc import Callable, Mapping
from typing import Any

import pytest

CONTRACTS = "bt_manip_contracts"
"""Marker of a test that is run once per contract check."""


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
        examples: `bt_manip_contracts.Example` by name of the behaviour; not needed for behaviours
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
