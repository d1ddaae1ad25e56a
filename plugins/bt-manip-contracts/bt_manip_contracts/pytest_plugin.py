"""The pytest plugin: tests of all parts of a plugin, by one line of a test module.

Every pytest session loads this module where the package is installed, so heavy imports are made
when pytest collects the tests.
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


def pytest_configure(config: pytest.Config) -> None:
    """Register the markers."""
    for line in (
        "soak: a check of a contract that takes long; only with -m soak (bt-manip-contracts)",
        f"{CONTRACTS}(plugin, ...): written by bt_manip_contracts.contracts_of",
    ):
        config.addinivalue_line("markers", line)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Parametrize tests by the checks of contracts."""
    marker = metafunc.definition.get_closest_marker(CONTRACTS)
    if marker is None:
        return
    from bt_manip import load_plugins
    from bt_manip_contracts.contract_list import checks_of

    checks = checks_of(load_plugins(), *marker.args, **marker.kwargs)
    if "soak" not in metafunc.config.option.markexpr:
        checks = [check for check in checks if not check.long]
    metafunc.parametrize(
        "bt_manip_contract",
        [pytest.param(c.run, id=c.id, marks=[pytest.mark.soak] * c.long) for c in checks],
    )
