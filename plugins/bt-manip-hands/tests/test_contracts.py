"""What the package brings keeps what every part of its kind promises."""

from bt_manip.testing import contracts_of

test_parts_keep_their_contracts = contracts_of("hands")
