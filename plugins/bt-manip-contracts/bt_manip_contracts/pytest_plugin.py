"""The pytest plugin: a test for each check of a contract.

Every pytest session loads this module where the package is installed, so heavy imports are made
when a test asks for contracts.
"""

import pytest

from bt_manip_contracts.contracts import CONTRACTS


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
