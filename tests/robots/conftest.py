from tests.support.program import bt_manip as bt_manip
