"""The faults of the package keep the contract of faults."""

from bt_manip_contracts import contracts_of

test_contracts = contracts_of("stress")
