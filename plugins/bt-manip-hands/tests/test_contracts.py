"""What the package brings keeps what every part of its kind promises."""

import pytest

from bt_manip_contracts import contracts_of

pytestmark = pytest.mark.usefixtures("hand_models")

test_parts_keep_their_contracts = contracts_of("hands")
