"""The panel shows the events and samples of a run."""

from types import SimpleNamespace
from unittest.mock import MagicMock

import numpy as np

from bt_manip_gear.gear import Gear


def test_it_shows_the_running_node_and_the_error():
    panel = Gear(MagicMock())  # in place of the page
    panel.shown_node, panel.shown_error = SimpleNamespace(), SimpleNamespace()
    panel.start(None)
    status = {"path": "pick/Reach::4", "status": "RUNNING"}
    panel.handle(SimpleNamespace(kind="status", data=status))
    q_ref = np.zeros((1, 7))
    panel.sample(np.array([0.01]), {"panda": (q_ref + 2e-3, q_ref)})
    panel.draw()
    assert panel.shown_node.value == "pick/Reach::4"
    assert panel.shown_error.value == 2.0
