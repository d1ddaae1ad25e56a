"""Each robot of the package keeps what every robot promises."""

from bt_manip_contracts import contracts_of

test_robots_keep_their_contracts = contracts_of("menagerie")
