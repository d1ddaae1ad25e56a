"""The recorder."""

from bt_manip.exceptions import BtManipError
from bt_manip.runner import RunObserver


class Gear(RunObserver):
    """Write the time [s] and the position of the tool [m] after every tick."""

    suffix = ".gear"  # selects this recorder

    def __init__(self, path):
        """Open the file."""
        if path is None:
            raise BtManipError("the recorder needs a file: gear=FILE")
        self.file = path.open("w")

    def run_started(self, run):
        """Store the station."""
        self.station = run.station

    def after_tick(self):
        """Write a line."""
        x, y, z = self.station.robot.tool_pose.translation
        self.file.write(f"{self.station.cell.time:.3f} {x:.6f} {y:.6f} {z:.6f}\n")

    def run_ended(self):
        """Close the file, however the run ends."""
        self.file.close()
