"""Buttons that save the run on the page: its recording and its report."""

import tempfile
from pathlib import Path
from typing import Any

from bt_manip.record import RunReport
from bt_manip.runner import Run

from .panel import Panel

RECORDING = "/recording.mcap"

REPORT = "/report.json"


class KeepPanel(Panel):
    """Offers the recording of the kept past as a download, and after the run its report.

    Attributes:
        report: The report of the run; None until it has ended.
    """

    place = "bar"
    needs_run = True

    def __init__(self, page: Any) -> None:
        self._page = page
        self._run: Run | None = None
        self.report: RunReport | None = None
        self._recording = page.gui.add(
            "download", label="Save recording", path=RECORDING,
            hint="Save scene, joints and tree at each tick so far, for bt-manip replay and report",
        )  # fmt: skip
        self._report = page.gui.add(
            "download", label="Report", path=REPORT,
            hint="Save the report of the run that has ended, as of --report",
        )  # fmt: skip
        page.site.downloads |= {RECORDING: self._record, REPORT: self._write_report}

    def start(self, run: Run) -> None:
        """Offer this run."""
        self._run, self.report = run, None

    def draw(self) -> None:
        """Enable the buttons for what there is."""
        self._recording.disabled = not self._page.past.times
        self._report.disabled = self.report is None or not self._page.past.times

    # Downloads, in a thread of their own

    def _record(self) -> tuple[str, bytes] | None:
        from bt_manip_recording import record_states

        run, past = self._run, self._page.past.copy()
        if run is None or not past.times:
            return None
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "run.mcap")
            record_states(run, past, path)
            return f"{_name(run)}.mcap", path.read_bytes()

    def _write_report(self) -> tuple[str, bytes] | None:
        run, report = self._run, self.report
        if run is None or report is None:
            return None
        return f"{_name(run)}.json", report.to_json().encode()


def _name(run: Run) -> str:
    """Return the name of the files of a run, without a suffix."""
    name = Path(run.request.tree.name).stem
    return f"{''.join(c if c.isalnum() or c in '-_' else '_' for c in name)}-{run.request.seed}"
