"""The panel."""

import numpy as np
from bt_manip_view import Panel


class Gear(Panel):
    """Shows the running node and the largest tracking error of a joint."""

    def __init__(self, page):
        """Add a text and a number to the page."""
        self.shown_node = page.gui.add_text("Node", "")
        self.shown_error = page.gui.add_number("Error [mrad]", 0.0, disabled=True)
        self.reset()

    def start(self, run):
        """Clear the previous run."""
        self.reset()

    def reset(self):
        """Clear all events and samples."""
        self.node, self.error = "", 0.0

    def handle(self, event):
        """Store the node that starts to run."""
        if event.kind == "status" and event.data["status"] == "RUNNING":
            self.node = event.data["path"]

    def sample(self, times, joints):
        """Store the largest error of the last tick."""
        errors = [np.abs(q - q_ref)[-1].max() for q, q_ref in joints.values()]
        self.error = 1e3 * float(max(errors, default=0.0))

    def draw(self):
        """Send both to the open pages."""
        self.shown_node.value, self.shown_error.value = self.node, round(self.error, 3)
