from bt_manip_contracts import contracts_of

test_robots_keep_their_contracts = contracts_of("menagerie")
